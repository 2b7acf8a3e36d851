"""A target of snapshots with everything on, whose numbers are changed and which are sealed again.

They must be refused, or worked on. Damaged bytes rarely pass the first check; these do. A loop in compiled code ignores
timers. The program is then ended with a traceback.
"""

import contextlib
import faulthandler
import functools
import hashlib
import random
import struct
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from checks.fuzz.target import Feed, Target
from checks.random_takes import moves_of
from mossar_adapters.demo import performance
from mossar_stream import Segmenter, Settings, Skeleton, to_json

MOVES = ("punch_left", "squat", "wave_left", "kick_right", "squat", "stand:1")
CUTS = (100, 300, 450)  # frames after which the snapshots were made
AFTER = 96  # frames that are pushed then
LIMIT = 30.0  # s for an input, beyond that of the guard
HEAD, DIGEST = 8, 32  # bytes of a snapshot: magic and version, then the SHA-256 of the rest
WHOLE = (-1, 0, 1, 2, 3, 7, 63, 64, 255, 10**6, 2**31, -(2**31), 2**53, 2**62, -(2**63))
BROKEN = (float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e30, -1.0, 5e-324, 1e-3, 0.0)
READERS = ("recognition", "steps", "followed", "poses")


def sealed_targets() -> list[Target]:
    """Return the target."""
    return [Target("snapshot rows", 0.2, _opened, draw=_draw, round=50)]


@functools.cache
def _take() -> tuple[Skeleton, NDArray[np.float32], NDArray[np.float64]]:
    take = performance(5, fps=30.0, seconds=25.0, moves=MOVES * 6)
    return take.skeleton, np.array(take.frames.positions, np.float32), np.array(take.frames.times)


@functools.cache
def _blobs() -> tuple[bytes, ...]:
    """Return snapshots in the midst of a take."""
    skeleton, positions, times = _take()
    made = []
    for level in ("motion", "posture"):
        settings = Settings(limbs=True, repetitions=True, phase=True, steps=True, level=level)
        for cut in CUTS:
            one = Segmenter(skeleton, settings, moves=moves_of(3), follow=True)
            one.push(positions[:cut], times[:cut])
            made.append(one.snapshot())
    return tuple(made)


def _draw(rng: random.Random) -> Callable[[], bytes]:
    return lambda: _hurt(rng.choice(_blobs()), rng)


def _hurt(blob: bytes, rng: random.Random) -> bytes:
    """Return a snapshot with some changed numbers and the right checksum."""
    content = msgspec.msgpack.decode(blob[HEAD + DIGEST :])
    following, count = content["following"], rng.choice([1, 1, 1, 3, 30])
    part = rng.choice(["row", "limb", "limb", "tree", *READERS])
    if part == "limb" and following["limbs"]:
        limbs = list(following["limbs"])
        place = rng.randrange(len(limbs))
        limbs[place] = _hurt(limbs[place], rng)
        following["limbs"] = limbs
    elif part == "tree":
        for _ in range(count):
            _scratch_tree({name: following[name] for name in ("repetitions", "numbers")}, rng)
    elif part in READERS and following.get(part):
        following[part] = _scratched(following[part], rng, count)
    else:
        content["row"] = _scratched(content["row"], rng, count)
    body = msgspec.msgpack.encode(content)
    return blob[:HEAD] + hashlib.sha256(body).digest() + body


def _scratched(data: bytes, rng: random.Random, count: int) -> bytes:
    """Return bytes in which some numbers are others."""
    own = bytearray(data)
    for _ in range(count):
        kind = rng.choice("qqqddddfi?")
        if kind == "?":
            own[rng.randrange(len(own))] ^= 1 << rng.randrange(8)
            continue
        size = struct.calcsize(kind)
        at = rng.randrange(max(1, len(own) // size)) * size
        number: float = rng.choice(BROKEN if kind in "df" else WHOLE)
        if kind == "f":
            number = float(np.float32(np.clip(number, -3e38, 3e38)))
        elif kind == "i":
            number = (int(number) + 2**31) % 2**32 - 2**31
        own[at : at + size] = struct.pack(f"={kind}", number)[: len(own) - at]
    return bytes(own)


def _scratch_tree(tree: Any, rng: random.Random) -> None:
    """Change a number somewhere in maps and lists."""
    while isinstance(tree, dict | list) and tree:
        key = rng.choice([*tree]) if isinstance(tree, dict) else rng.randrange(len(tree))
        inner = tree[key]
        if not (isinstance(inner, dict | list) and inner):
            tree[key] = rng.choice([*WHOLE[:-1], *BROKEN, None, {}, [], "", True])
            return
        tree = inner


@contextlib.contextmanager
def _opened() -> Iterator[Feed]:
    _, positions, times = _take()

    def feed(blob: bytes) -> None:
        faulthandler.dump_traceback_later(LIMIT, exit=True)
        try:
            segmenter = Segmenter.restore(blob)
            begin = int(np.searchsorted(times, 20.0)) if segmenter.state is None else 450
            events = []
            for at in range(begin, begin + AFTER, 32):
                events += segmenter.push(positions[at : at + 32], times[at : at + 32])
            events += Segmenter.restore(segmenter.snapshot()).end_take() + segmenter.end_take()
            for event in events:
                to_json(event)
        finally:
            faulthandler.cancel_dump_traceback_later()

    yield feed
