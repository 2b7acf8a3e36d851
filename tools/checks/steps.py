"""Steps: scores of foot strikes and offs: `python -m checks.steps [FILE.c3d ...]`.

Truth are made gaits, the built-in performer, and of C3D files the events of a gait laboratory and the force plates. The figures
of docs/steps.md are printed by this program.
"""

import argparse
import itertools
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import msgspec.structs
import numpy as np
from numpy.typing import NDArray

from checks.c3d_forces import contacts
from checks.gaits import FEET, GAITS, SKELETON, Event, performed, wiggling
from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.annotations.tiers import STEPS, AnnotationError, Mark
from mossar_adapters.demo import performance
from mossar_adapters.files import read
from mossar_stream import Segmenter, Settings, Skeleton, StepEvent, segment_recording
from mossar_tools.evaluation.matching import Cut, match

STRIKE, OFF, SLOW = 0.05, 0.07, 0.1  # s: tolerances at 60 Hz and more, and at 30 Hz
EDGE = 0.2  # s at the ends of a recording in which an event is not seen whole
FOUND = 0.25  # s within which an event is the same one, for F1


def found_in(
    positions: NDArray[np.float32], times: NDArray[np.float64], skeleton: Skeleton, feet: str = ""
) -> list[StepEvent]:
    """Return the steps of a recording."""
    settings = Settings(steps=True, feet=feet, level="posture")
    return segment_recording(positions, None, skeleton, settings, times=times).steps


def row(
    name: str, found: Sequence[StepEvent], truth: Sequence[Event], fps: float, delays: bool = True
) -> str:
    """Return a line: number of events, F1 within 0.25 s, shares within the tolerances, median errors and delay."""
    hits, errors = 0, {"strike": [], "off": []}  # type: ignore[var-annotated]
    for side in ("left", "right"):
        for status, own in errors.items():
            cuts = [Cut(t, t, t) for t, s, what in truth if (s, what) == (side, status)]
            times = sorted(e.time for e in found if (e.side, e.status) == (side, status))
            matched = match(times, cuts, FOUND)
            hits += len(matched)
            own += [hit.error for hit in matched]
    f1 = 2 * hits / max(1, len(found) + len(truth))
    cells = []
    for status, limit in (("strike", STRIKE), ("off", OFF)):
        tolerance = limit if fps > 45 else SLOW
        total = sum(what == status for _, _, what in truth)
        near = sum(abs(error) <= tolerance + 1e-9 for error in errors[status])
        bias = 1000 * float(np.median(errors[status])) if errors[status] else float("nan")
        cells.append(f"{near / max(1, total):>6.2f} {bias:>+5.0f}")
    delay = (
        1000 * float(np.median([e.decided_time - e.time for e in found]))
        if found and delays
        else float("nan")
    )
    return f"{name:<34}{len(truth):>5}{len(found):>6}{f1:>6.2f}  {cells[0]}  {cells[1]}{delay:>8.0f}"


def made() -> None:
    """Print a line for each gait, at 100 Hz with the noise of markers, and at 30 Hz with that of a camera."""
    for name, gait in GAITS.items():
        for fps, noise in ((100.0, 0.001), (30.0, 0.005)):
            positions, times, truth = performed(gait, 30.0, fps, noise)
            found = found_in(positions, times, SKELETON, FEET)
            print(row(f"{name}, {fps:.0f} Hz, {1000 * noise:.0f} mm", found, truth, fps))


def built_in() -> None:
    """Print a line for the built-in performer that walks and turns, whose feet do not slide."""
    for fps, noise in ((60.0, 0.0), (60.0, 0.005), (30.0, 0.005)):
        found: list[StepEvent] = []
        truth: list[Event] = []
        for seed in range(1, 6):
            whole = performance(seed, fps=fps, moves=["rest", "walk", "turn", "walk", "rest"], noise=noise)
            clean = performance(seed, fps=fps, moves=["rest", "walk", "turn", "walk", "rest"])
            shift = 1000.0 * seed
            times = whole.frames.times
            found += [
                _later(event, shift) for event in found_in(whole.frames.positions, times, whole.skeleton)
            ]
            known = stood(clean.frames.positions, times, clean.skeleton)
            truth += [(moment + shift, side, status) for moment, side, status in known]
        print(row(f"built-in, {fps:.0f} Hz, {1000 * noise:.0f} mm", found, truth, fps, delays=False))


def _later(event: StepEvent, shift: float) -> StepEvent:
    return msgspec.structs.replace(event, time=event.time + shift)


def stood(positions: NDArray[np.float32], times: NDArray[np.float64], skeleton: Skeleton) -> list[Event]:
    """Return the times at which toes of the built-in performer, which do not slide, left their place by 5 mm or came to rest."""
    truth: list[Event] = []
    for side, name in (("Left", "left"), ("Right", "right")):
        toes = positions[:, skeleton.names.index(f"{side}Toes")]
        still = np.linalg.norm(np.diff(toes, axis=0), axis=1) < 1e-5
        edges = np.flatnonzero(np.diff(still.astype(int))) + 1
        stops = [0, *edges.tolist(), len(still)]
        for begin, end in itertools.pairwise(stops):
            if still[begin] or end - begin < 4:
                continue
            way = np.linalg.norm(toes[begin : end + 1] - toes[begin], axis=1)
            back = np.linalg.norm(toes[begin : end + 1] - toes[end], axis=1)
            if way.max() > 0.03:
                truth.append((float(times[begin + int(np.argmax(way > 0.005))]), name, "off"))
                last = begin + len(back) - 1 - int(np.argmax(back[::-1] > 0.005))
                truth.append((float(times[last]), name, "strike"))
    return sorted(truth)


def recorded(path: Path, feet: str) -> None:
    """Print lines for a C3D file: against its events, and against its force plates."""
    whole = read(path)
    found = found_in(whole.positions, whole.times, whole.skeleton, feet)
    first, last = float(whole.times[0]), float(whole.times[-1])
    fps = whole.fps or 0.0
    try:
        tiers = {tier.name: tier for tier in read_annotations(path)}
    except AnnotationError:
        tiers = {}
    if STEPS in tiers:
        every = [_event(first, mark) for mark in tiers[STEPS].marks]
        truth = [event for event in every if first + EDGE < event[0] < last - EDGE]
        inside = [e for e in found if first + EDGE < e.time < last - EDGE]
        print(row(f"{path.name}: its events", inside, truth, fps))
    for status, moments in contacts(path).items():
        errors = []
        for moment in moments:
            own = [e.time - first - moment for e in found if e.status == status]
            nearest = min(own, key=abs, default=np.nan)
            errors.append(f"{1000 * nearest:+.0f}" if abs(nearest) < FOUND else "none")
        print(f"{path.name}: force plates, {status}: ms from each {' '.join(errors)}")


def _event(first: float, mark: Mark) -> Event:
    side, _, status = mark.label.partition(" ")
    return first + mark.start, side, status


def standing() -> None:
    """Print the number of steps in ten minutes of standing and wiggling."""
    for fps, noise in ((100.0, 0.001), (30.0, 0.005), (30.0, 0.01)):
        positions = wiggling(600.0, fps, noise)
        found = found_in(positions, np.arange(len(positions)) / fps, SKELETON, FEET)
        print(f"ten minutes of wiggling, {fps:.0f} Hz, {1000 * noise:.0f} mm: {len(found)} events")


def speed() -> None:
    """Print the cost of steps for a frame, in a chunk and by itself."""
    positions, times, _ = performed(GAITS["walking"], 60.0, 60.0)
    together, alone = {}, {}
    for steps in (False, True):
        chunk, single = [], []
        for _ in range(9):
            segmenter = Segmenter(SKELETON, Settings(steps=steps, feet=FEET))
            start = time.perf_counter()
            segmenter.push(positions, times)
            chunk.append((time.perf_counter() - start) / len(times))
            segmenter = Segmenter(SKELETON, Settings(steps=steps, feet=FEET))
            start = time.perf_counter()
            for position, moment in zip(positions, times.tolist(), strict=True):
                segmenter.push(position, moment)
            single.append((time.perf_counter() - start) / len(times))
        together[steps], alone[steps] = np.median(chunk), np.median(single)
    more = [1e6 * (cost[True] - cost[False]) for cost in (together, alone)]
    print(f"a frame costs {more[0]:.2f} us more in a chunk, {more[1]:.2f} us more by itself")


def main() -> int:
    """Print everything."""
    parser = argparse.ArgumentParser(prog="python -m checks.steps", description="How well steps are found.")
    parser.add_argument("files", metavar="FILE.c3d", nargs="*", type=Path)
    parser.add_argument("--feet", default="", help="joints of the feet of the files, if they are not known")
    given = parser.parse_args()
    print(f"{'':<34}{'true':>5}{'found':>6}{'F1':>6}{'strike ms':>14}{'off ms':>14}{'delay':>8}")
    made()
    built_in()
    for path in given.files:
        recorded(path, given.feet)
    standing()
    speed()
    return 0


if __name__ == "__main__":
    sys.exit(main())
