"""Moves: the cost of recognising moves per frame, and the longest pushes, with a game's number of examples."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from checks.speed.turns import added, waits
from mossar_stream import Moves, Segmenter, Settings
from mossar_tools.bench.measurement import Measurement
from mossar_tools.bench.motion import Motion, performer
from mossar_tools.bench.work import Work

JOINTS, EXAMPLES, EACH = 21, 28, 2
SECONDS = 1.0  # of an example
MORE = 2.0  # µs that a frame may take longer on average
LONGEST = 500.0  # µs, p99.9 of a push


def measure(work: Work) -> Iterator[Measurement]:
    """Yield the mean time that moves add to a push, its 99.9 % quantile, and the memory of a performer."""
    seconds = work.some(120, 8)
    motion = performer(seconds, joints=JOINTS)
    moves = examples_of(performer(120, joints=JOINTS, seed=2))  # a shorter motion rests in some stretches
    runs = [waits(motion, _pair(motion, moves), work.some(50_000, 2000)) for _ in range(work.some(5, 1))]
    what = f"{motion.name}, {len(moves)} examples, {JOINTS} joints"
    yield from added("moves", what, runs, MORE, LONGEST)
    plain, own = (Segmenter(motion.skeleton, Settings(), moves=found).state_bytes for found in (None, moves))
    yield Measurement("moves", "memory of a performer, besides the examples", "kB", ((own - plain) / 1000,))


def _pair(motion: Motion, moves: Moves) -> list[Segmenter]:
    return [Segmenter(motion.skeleton, Settings(), fps=motion.fps, moves=own) for own in (None, moves)]


def examples_of(motion: Motion) -> Moves:
    """Return moves whose examples are parts of a motion: the liveliest part of each stretch."""
    length = min(round(SECONDS * motion.fps), len(motion.times) // EXAMPLES)
    begins = np.arange(EXAMPLES) * (len(motion.times) // EXAMPLES)
    moves = Moves(motion.skeleton)
    for k, begin in enumerate(begins):
        moves.add(f"move {k // EACH + 1}", _liveliest(motion, int(begin), length), motion.fps)
    return moves


def _liveliest(motion: Motion, begin: int, length: int) -> NDArray[np.float32]:
    """Return the part of a stretch of a motion in which the joints move most."""
    until = begin + len(motion.times) // EXAMPLES
    steps = np.linalg.norm(np.diff(motion.positions[begin:until], axis=0), axis=2).sum(axis=1)
    paths = np.convolve(steps, np.ones(length - 1), "valid")
    first = begin + int(np.argmax(paths))
    return motion.positions[first : first + length]
