"""Targets that read the files of a former run: snapshots.

A checksum would refuse nearly all damage at once. Most inputs therefore get a right one.
"""

import contextlib
import hashlib
from collections.abc import Callable, Iterator

import numpy as np

from checks.fuzz.files import scratch
from checks.fuzz.target import Feed, Target
from mossar_adapters.demo import DemoSource
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.pipeline import Pipeline, Upkeep, read_snapshot
from mossar_adapters.pipeline.snapshot import sealed as sealed_run
from mossar_stream import Segmenter, Settings

_JOINTS = len(SKELETON)
_MAGIC_BYTES, _DIGEST_BYTES = 8, 32  # of a snapshot: magic and version, then the SHA-256 of the rest
_UNSEALED = 8  # one in so many inputs keeps its damaged checksum


def state_targets() -> list[Target]:
    """Return the targets."""
    return [
        Target("snapshot", 2.0, _segmenter, [_blob(Settings()), _blob(Settings.build("paper"))]),
        Target("snapshot file", 2.0, _run, [_written()]),
    ]


def _poses(count: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Return frames of a performer who moves and rests."""
    steps = np.sin(np.arange(count) / 5) * (np.arange(count) // 20 % 2)
    poses = np.zeros((count, _JOINTS, 3), np.float32)
    poses[:, 1:, 0] = steps[:, None] * np.linspace(0, 1, _JOINTS - 1)
    return poses


def _blob(settings: Settings) -> bytes:
    """Return the snapshot of a segmenter in the middle of a take, without the head."""
    segmenter = Segmenter(SKELETON, settings, fps=60.0)
    segmenter.push(_poses(150))
    return segmenter.snapshot()[_MAGIC_BYTES + _DIGEST_BYTES :]


def _mostly(seal: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Return a function that puts a right head before most bodies, and none before the others."""
    return lambda body: body if len(body) % _UNSEALED == 0 else seal(body)


@contextlib.contextmanager
def _segmenter() -> Iterator[Feed]:
    poses = _poses(30)
    magic = Segmenter(SKELETON).snapshot()[:_MAGIC_BYTES]
    seal = _mostly(lambda body: magic + hashlib.sha256(body).digest() + body)

    def feed(body: bytes) -> None:
        segmenter = Segmenter.restore(seal(body))
        if segmenter.skeleton == SKELETON:
            segmenter.push(poses, 2.5 + np.arange(len(poses)) / 60)
            segmenter.end_take()
            segmenter.snapshot()

    yield feed


def _source() -> DemoSource:
    return DemoSource(1, seconds=0.5, speed="max")


def _written() -> bytes:
    """Return the snapshot of a run that was cut short, without the head."""
    with scratch() as folder:
        path = folder / "state"
        pipeline = Pipeline([_source()], [], upkeep=Upkeep(snapshot=path))
        pipeline.stop()
        pipeline.run()
        return path.read_bytes()[len(sealed_run(b"")) :]


@contextlib.contextmanager
def _run() -> Iterator[Feed]:
    seal = _mostly(sealed_run)
    with scratch() as folder:
        path = folder / "state"

        def feed(body: bytes) -> None:
            path.write_bytes(seal(body))
            found = read_snapshot(path)
            if found is not None:
                Pipeline([_source()], [], resume=found)

        yield feed
