"""Scores of level `motion` under other conditions than those of the recordings.

    python -m checks.conditions SET1 SET2 SET3 ...

Each SET is a labelled folder as for `mossar evaluate`. One line a condition: mean F1 of the final key frames of each set,
streamed with the defaults: as recorded, with noise on every joint, at half and at double speed (the tolerance with it).
Then, for the same takes at other rates (straight lines between the frames, or frames left out), the share of the final
key frames that stay within 0.1 s.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import KeyFrameEvent, Segmenter
from mossar_tools.console import Console
from mossar_tools.evaluation.matching import Cut, match
from mossar_tools.evaluation.takes import Take, load_folder

NOISE = 0.005  # m, standard deviation on each axis
SEED = 0
NEAR = 0.1  # s, within which a key frame is the same one


class Played(NamedTuple):
    """A take under a condition.

    Args:
        positions: (n, J, 3) m.
        fps: Hz.
        slowness: Its times are so many times those of the take.
    """

    positions: NDArray[np.float32]
    fps: float
    slowness: float = 1.0


def as_recorded(take: Take) -> Played:
    """Return a take unchanged."""
    return Played(take.positions, take.fps)


def noisy(take: Take) -> Played:
    """Return a take with white noise on every joint."""
    noise = np.random.default_rng(SEED).normal(0.0, NOISE, take.positions.shape)
    return Played((take.positions + noise).astype(np.float32), take.fps)


def at_half_speed(take: Take) -> Played:
    """Return a take whose frames come half as often."""
    return Played(take.positions, take.fps / 2.0, 2.0)


def at_double_speed(take: Take) -> Played:
    """Return a take whose frames come twice as often."""
    return Played(take.positions, take.fps * 2.0, 0.5)


def drawn_out(take: Take, times: int) -> Played:
    """Return a take with so many times the frames, on straight lines between its own."""
    places = np.arange(times * (len(take.positions) - 1) + 1)
    before = np.minimum(places // times, len(take.positions) - 2)
    share = ((places - times * before) / times).astype(np.float32)[:, None, None]
    way = np.where(share > 0.0, take.positions[before + 1] - take.positions[before], np.float32(0.0))
    poses = np.where(share < 1.0, take.positions[before] + share * way, take.positions[before + 1])
    return Played(poses, take.fps * times)


def every_second(take: Take) -> Played:
    """Return every second frame of a take."""
    return Played(np.ascontiguousarray(take.positions[::2]), take.fps / 2.0)


CONDITIONS: dict[str, Callable[[Take], Played]] = {
    "as recorded": as_recorded,
    "5 mm of noise": noisy,
    "half speed": at_half_speed,
    "double speed": at_double_speed,
}
RATES: dict[str, Callable[[Take], Played]] = {
    "twice the rate": lambda take: drawn_out(take, 2),
    "four times the rate": lambda take: drawn_out(take, 4),
    "half the rate": every_second,
}


def final(take: Take, played: Played) -> list[float]:
    """Return the final key frames of a stream, s."""
    segmenter = Segmenter(take.skeleton, fps=played.fps)
    events = segmenter.push(played.positions) + segmenter.end_take()
    return sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "final")


def f1(take: Take, played: Played) -> float:
    """Return the F1 of the final key frames against the cuts, all of them played as slowly."""
    slow = played.slowness
    cuts = [Cut(*(slow * time for time in msgspec.structs.astuple(cut))) for cut in take.cuts]
    times = final(take, played)
    return 2 * len(match(times, cuts, slow * take.tolerance)) / max(1, len(times) + len(cuts))


def staying(takes: Sequence[Take], change: Callable[[Take], Played]) -> float:
    """Return the share of the final key frames that have one of the changed takes near them, one to one."""
    same = most = 0
    for take in takes:
        before, after = final(take, as_recorded(take)), final(take, change(take))
        same += len(match(after, [Cut(time, time, time) for time in before], NEAR))
        most += max(len(before), len(after))
    return same / max(1, most)


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", metavar="SET", nargs="+", type=Path)
    console = Console(sys.stdout, sys.stderr)
    sets = {folder.name: load_folder(folder, console.status) for folder in parser.parse_args().folders}
    console.line(f"{'':<20}" + "".join(f"{name:>15}" for name in (*sets, "mean")))
    for name, change in CONDITIONS.items():
        scores = [float(np.mean([f1(take, change(take)) for take in takes])) for takes in sets.values()]
        _tell(console, name, [*scores, float(np.mean(scores))])
    for name, change in RATES.items():
        _tell(console, name, [staying(takes, change) for takes in sets.values()])


def _tell(console: Console, name: str, values: Sequence[float]) -> None:
    console.line(f"{name:<20}" + "".join(f"{value:>15.3f}" for value in values))


if __name__ == "__main__":
    main()
