"""Exactness of counted repetitions: whole takes, with pauses and noise, slow, quick, and without a rest around them.

    python -m checks.counts LABELLED [--moves MOVES] [--only WORD] [--list]

LABELLED is a folder of labelled sets: `ui_prmd`, whose labels have the number of repetitions of a take, `precog` and `vmci`,
in which little is repeated. MOVES is a folder of single moves (`*.npz`, an array a move), which are repeated here.

A row is a kind of series: takes, the share counted exactly and within one, mean error / count, F1 of the ends between
repetitions, messages, and the number of those whose `total` is lower than in the one before.
"""

import argparse
import itertools
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_stream import RepetitionEvent, Segmenter, Settings, Skeleton
from mossar_tools.console import Console
from mossar_tools.evaluation.matching import Cut, match

Array = NDArray[np.float32]
RATE, QUICK_RATES = 30.0, (30.0, 120.0)  # Hz
LENGTHS = (0.7, 1.0, 8.0)  # s, of each of three repetitions
PAUSE, PAUSED_AFTER = 12.0, 5  # s, repetitions
NOISES = (0.0, 0.002, 0.004)  # m
REST = 1.0  # s
QUICK = ("duck", "push", "jab_left", "hook_right", "uppercut_left", "kick_right", "sidekick_left")
QUICK_LENGTHS = (0.4, 0.7, 1.0)  # s
QUICK_COUNTS = (3, 4, 5)
ACTIVE = 0.15  # of its fastest, above which a move has begun
NEAR = 0.25  # s, of an end
ONE_END = 0.3  # s, within which an end and the next begin are one


class Series(msgspec.Struct, frozen=True):
    """A recording in which something is repeated.

    Args:
        kind: Kind of the series.
        name: Its own.
        positions: (n, J, 3) float32, m.
        fps: Hz.
        skeleton: The joints.
        count: True repetitions.
        cuts: s, where one ends and the next begins.
    """

    kind: str
    name: str
    positions: Array
    fps: float
    skeleton: Skeleton
    count: int
    cuts: list[Cut]


class Counted(msgspec.Struct, frozen=True):
    """Counts of a series.

    Args:
        count: Repetitions.
        f1: Of the ends between them.
        messages: Events.
        corrected: Events whose `total` is lower than in the one before.
        spans: s, begin and end of each repetition.
    """

    count: int
    f1: float
    messages: int
    corrected: int
    spans: list[tuple[float, float]]


def count(series: Series) -> Counted:
    """Return the counts of a streamed series."""
    segmenter = Segmenter(series.skeleton, Settings(repetitions=True), fps=series.fps)
    events = segmenter.push(series.positions) + segmenter.end_take()
    said = [event for event in events if isinstance(event, RepetitionEvent)]
    latest = {event.id: event for event in said}
    last = [event for event in latest.values() if event.status == "counted"]
    spans = [(event.start or 0.0, event.end or 0.0) for event in last]
    ends: list[float] = []
    for time in (time for span in spans for time in span):
        if not ends or time - ends[-1] > ONE_END:
            ends.append(time)
    ends = ends[1:-1]  # where a take begins or ends there is no cut
    f1 = 2 * len(match(ends, series.cuts, NEAR)) / max(1, len(ends) + len(series.cuts))
    corrected = sum(b.total < a.total for a, b in itertools.pairwise(said))
    return Counted(len(last), f1, len(said), corrected, spans)


def labelled(folder: Path) -> Iterator[tuple[str, Array, float, Skeleton, list[tuple[int, int, int]], int]]:
    """Yield name, positions, rate, skeleton, cuts in frames and repetitions of the takes of a set."""
    for path in sorted(folder.glob("*.json")):
        labels = json.loads(path.read_text())
        take = np.load(path.parent / labels["recording"])
        skeleton = Skeleton(tuple(map(str, take["joint_names"])), tuple(map(int, take["parents"])))
        positions = np.ascontiguousarray(take["positions"], np.float32)
        yield path.stem, positions, float(take["fps"]), skeleton, labels["cuts"], labels.get("repetitions", 0)


def resampled(positions: Array, frames: int) -> Array:
    """Return a movement over so many frames, on straight lines between its poses."""
    grid = np.linspace(0.0, len(positions) - 1.0, frames)
    below = np.minimum(grid.astype(int), len(positions) - 2)
    share = (grid - below)[:, None, None]
    return np.asarray((1 - share) * positions[below] + share * positions[below + 1], np.float32)


def whole_takes(folder: Path) -> Iterator[Series]:
    """Yield takes of exercises, unchanged and with a pause."""
    for name, positions, fps, skeleton, cuts, repetitions in labelled(folder):
        spans = [Cut(*(frame / fps for frame in cut)) for cut in cuts]
        yield Series(f"{folder.name}, as recorded", name, positions, fps, skeleton, repetitions, spans)
        middle = cuts[PAUSED_AFTER - 1][1]
        for noise in NOISES:
            rng = np.random.default_rng(0)
            pause = np.repeat(positions[middle : middle + 1], int(PAUSE * fps), axis=0)
            pause = pause + rng.normal(0.0, noise, pause.shape).astype(np.float32)
            held = np.concatenate([positions[:middle], pause, positions[middle:]])
            later = [cut if cut.middle <= middle / fps else shifted(cut, PAUSE) for cut in spans]
            # A repetition ends before it, one begins after it.
            later.append(shifted(spans[PAUSED_AFTER - 1], PAUSE))
            kind = f"{folder.name}, {PAUSE:g} s of pause, {1000 * noise:g} mm"
            yield Series(kind, name, held, fps, skeleton, repetitions, later)


def shifted(cut: Cut, seconds: float) -> Cut:
    """Return a cut at a later time."""
    return Cut(cut.earliest + seconds, cut.middle + seconds, cut.latest + seconds)


def threes(folder: Path) -> Iterator[Series]:
    """Yield three repetitions of exercises, each of the same length, between rests."""
    for name, positions, _, skeleton, cuts, _ in labelled(folder):
        frames = [cut[1] for cut in cuts[:4]]
        for length in LENGTHS:
            n, rest = round(length * RATE), int(REST * RATE)
            parts = [resampled(positions[a:b], n) for a, b in itertools.pairwise(frames)]
            held = [np.repeat(pose, rest, axis=0) for pose in (parts[0][:1], parts[-1][-1:])]
            cut = [REST + k * n / RATE for k in (1, 2)]
            spans = [Cut(time, time, time) for time in cut]
            kind = f"{folder.name}, three of {length:g} s"
            yield Series(kind, name, np.concatenate([held[0], *parts, held[1]]), RATE, skeleton, 3, spans)


def active(positions: Array) -> Array:
    """Return the part of a move from its begin to its end, without the rest around it."""
    relative = positions - positions[:, :1]
    speed = np.linalg.norm(np.diff(relative, axis=0), axis=2).mean(axis=1)
    speed = np.convolve(speed, np.ones(5) / 5, "same")
    moving = np.flatnonzero(speed > ACTIVE * speed.max())
    return np.asarray(positions[moving[0] : moving[-1] + 2])


def closed(positions: Array) -> Array:
    """Return a move that ends in the pose in which it begins."""
    share = np.linspace(0.0, 1.0, len(positions), dtype=np.float32)[:, None, None]
    return np.asarray(positions - share * (positions[-1] - positions[0]), np.float32)


def quick(folder: Path) -> Iterator[Series]:
    """Yield single moves, each repeated three to five times without a rest."""
    place = 0
    for path in sorted(folder.rglob("*.npz")):
        arrays = np.load(path)
        for name in arrays.files:
            if name.rsplit("_", 1)[0] not in QUICK or arrays[name].shape[1:] != (21, 3):
                continue
            place += 1
            if place % 3:
                continue
            move = closed(active(np.asarray(arrays[name], np.float32)))
            skeleton = Skeleton(*KINECT)
            length, n = QUICK_LENGTHS[place // 3 % 3], QUICK_COUNTS[place // 9 % 3]
            for fps in QUICK_RATES:
                frames = round(length * fps)
                once = resampled(move, frames + 1)[:-1]
                spans = [Cut(k * length, k * length, k * length) for k in range(1, n)]
                series = np.concatenate([*[once] * n, once[:1]])
                kind = f"quick, {fps:g} Hz"
                yield Series(kind, f"{path.stem}/{name}/{length}x{n}", series, fps, skeleton, n, spans)


def nothing(folders: list[Path]) -> Iterator[Series]:
    """Yield takes in which nothing is repeated."""
    for folder in folders:
        for name, positions, fps, skeleton, _, _ in labelled(folder):
            yield Series(f"{folder.name}, nothing repeated", name, positions, fps, skeleton, 0, [])


KINECT = (
    tuple(f"joint{i}" for i in range(21)),
    (-1, *[0] * 20),
)


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("labelled", metavar="LABELLED", type=Path)
    parser.add_argument("--moves", metavar="MOVES", type=Path)
    parser.add_argument("--only", metavar="WORD", default="", help="kinds of series that hold this word")
    parser.add_argument("--list", action="store_true", help="say which series are counted wrong")
    given = parser.parse_args()
    console = Console(sys.stdout, sys.stderr)
    rows: dict[str, list[tuple[Series, Counted]]] = {}
    sources = [whole_takes(given.labelled / "ui_prmd"), threes(given.labelled / "ui_prmd")]
    sources += [quick(given.moves)] if given.moves else []
    sources += [nothing([given.labelled / "precog", given.labelled / "vmci"])]
    for source in sources:
        for series in source:
            if given.only in series.kind:
                rows.setdefault(series.kind, []).append((series, count(series)))
    for kind, found in rows.items():
        errors = np.array([abs(counted.count - series.count) for series, counted in found])
        counts = np.array([max(series.count, 1) for series, _ in found])
        messages, corrected = (sum(getattr(c, what) for _, c in found) for what in ("messages", "corrected"))
        f1 = np.mean([counted.f1 for _, counted in found])
        console.line(
            f"{kind:<32} {len(found):3d} takes   exact {np.mean(errors == 0):.2f}   within one {np.mean(errors <= 1):.2f}"
            f"   error {np.mean(errors / counts):.3f}   F1 {f1:.2f}   corrections {corrected} of {messages}"
        )
        for series, counted in found if given.list else ():
            if counted.count != series.count:
                spans = " ".join(f"{a:.1f}-{b:.1f}" for a, b in counted.spans)
                console.line(f"    {series.name:<28} {counted.count} of {series.count}: {spans}")


if __name__ == "__main__":
    main()
