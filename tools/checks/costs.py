"""Costs of 64 slots and of long recordings, in processor time: neither may grow faster than it has to.

    python -m checks.costs [--minutes 4 32] [--slots 16 64]

Rows of slots: people of like bones fill all slots, leave for 5 s, and come back at once under new ids; the usual frame, and the
dearest one. Rows of recordings: of each length, for each kind of segmentation, and the cost of a minute of the longest relative
to one of the shortest. The exit status is 1 if that is more than `MOST_GROWTH`, or a frame of slots takes longer than
`MOST_SECONDS`.
"""

import argparse
import statistics
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.demo import performance
from mossar_adapters.people import Slots
from mossar_stream import Settings, Skeleton, segment_recording

FPS = 30.0
JOINTS = 15  # of people in slots
USUAL, DEAREST = 30, 30  # frames before and after the absence
MOST_SECONDS = 1.0  # of processor time for a frame of slots; a search of all assignments takes hours
MOST_GROWTH = 3.0  # a cost that grows with the square of the length grows by as much as the lengths differ
KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "limbs, repetitions, steps": {"limbs": True, "repetitions": True, "steps": True},
    "cluster, repetitions": {"repetitions": True, "level": "cluster"},
}


def cost_of_slots(count: int) -> tuple[float, float]:
    """Return the costs of a usual frame of so many people, and of the dearest one when all come back at once, s."""
    noise = np.random.default_rng(1)
    body = np.cumsum(noise.normal(0, 0.2, (JOINTS, 3)), axis=0)
    skeleton = Skeleton(tuple(f"j{j}" for j in range(JOINTS)), (-1, *range(JOINTS - 1)))
    slots = Slots(count)

    def seconds(begin: float, frame: int, name: str) -> float:
        poses = [
            (
                f"{name}{i}",
                body * (1 + 0.01 * np.sin(3.7 * i)) + [3.0 * i, 0, 0] + noise.normal(0, 1e-3, body.shape),
            )
            for i in range(count)
        ]
        begun = time.process_time()
        slots.decide(begin + frame / FPS, poses)
        return time.process_time() - begun

    for name in ("a", "b"):
        for i in range(count):
            slots.announce(f"{name}{i}", skeleton)
    usual = statistics.median(seconds(0.0, k, "a") for k in range(USUAL))
    return usual, max(seconds(USUAL / FPS + 5.0, k, "b") for k in range(DEAREST))


def cost_of_recording(
    positions: NDArray[np.float32], skeleton: Skeleton, minutes: float, settings: Settings
) -> float:
    """Return the cost of segmenting a recording of so many minutes, a repeated take, s."""
    count = int(60 * FPS * minutes)
    frames = np.tile(positions, (count // len(positions) + 1, 1, 1))[:count]
    begun = time.process_time()
    segment_recording(frames, FPS, skeleton, settings)
    return time.process_time() - begun


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the costs."""
    parser = argparse.ArgumentParser(prog="python -m checks.costs", description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", metavar="N", type=float, nargs="+", default=[4.0, 32.0])
    parser.add_argument("--slots", metavar="N", type=int, nargs="+", default=[16, 64])
    options = parser.parse_args(arguments)
    holds = True
    for count in options.slots:
        usual, dearest = cost_of_slots(count)
        holds &= dearest <= MOST_SECONDS
        print(
            f"{count} slots: a usual frame {1e3 * usual:.1f} ms; all come back at once: {1e3 * dearest:.1f} ms"
        )
    take = performance(1, fps=FPS, seconds=20.0)
    for name, changes in KINDS.items():
        costs = [
            cost_of_recording(take.frames.positions, take.skeleton, minutes, Settings(**changes))
            for minutes in options.minutes
        ]
        each = [cost / minutes for cost, minutes in zip(costs, options.minutes, strict=True)]
        growth = each[-1] / each[0]
        holds &= growth <= MOST_GROWTH
        found = ", ".join(
            f"{minutes:g} min {cost:.2f} s" for minutes, cost in zip(options.minutes, costs, strict=True)
        )
        print(f"recordings, {name}: {found}; a minute of the longest costs {growth:.2f} times as much")
    print("costs hold" if holds else "a cost grows too fast")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
