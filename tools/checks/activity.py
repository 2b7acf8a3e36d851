"""Delay and certainty of the activity, and the delay of every other event.

    python -m checks.activity [SET ...] [--holds DIR] [--demos 20] [--seconds 60] [--minutes 10]

First the activity: whether each bout of movement of the built-in performer has exactly one `moving` and one `resting`,
and their delays; bouts too short to be one in the labelled SETs; and bouts that noise causes for a standing performer. Then the delays of key frames and segments by level, as docs/events.md has them, from the performer and the SETs.
With --holds the F1 of the final key frames on recordings of holds, for both values of the setting `rests`.
"""

import argparse
from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np

from mossar_adapters.demo import performance
from mossar_stream import (
    BODY,
    LEVEL_NAMES,
    ActivityEvent,
    Event,
    Frames,
    KeyFrameEvent,
    Segmenter,
    SegmentEvent,
    Settings,
    Skeleton,
)
from mossar_stream import Rests as RestsName
from mossar_tools.evaluation.matching import match
from mossar_tools.evaluation.takes import Take, load_folder

FLICKER = 0.15  # s; a bout that is shorter is none
AROUND = 0.5  # s, before a bout begins or after it ends, in which its activity may be reported to begin
NOISE = 0.005  # m, on each axis
RATE = 30.0  # Hz
RESTS = ("rest", "stand")  # moves of the performer
LAST = 1.0  # s, that the rest after a bout must last before the recording ends
PRESETS = ("default", "game", "paper")


class Bout(NamedTuple):
    """A bout of movement, s."""

    begin: float
    end: float


class Reported(NamedTuple):
    """Reports of the activity of a performer.

    Args:
        events: Those of the body.
        end: When the last frame came, s.
    """

    events: list[ActivityEvent]
    end: float

    @property
    def bouts(self) -> list[Bout]:
        """The bouts that have ended."""
        return [
            Bout(before.start, after.start)
            for before, after in pairwise(self.events)
            if before.state == "moving"
        ]

    @property
    def flickers(self) -> int:
        """Bouts that are too short to be one."""
        return sum(bout.end - bout.begin < FLICKER for bout in self.bouts)


def streamed(skeleton: Skeleton, frames: Frames, settings: Settings, fps: float | None) -> list[Event]:
    """Return the events of a stream."""
    segmenter = Segmenter(skeleton, settings, fps=fps)
    return [*segmenter.push(frames.positions, frames.times), *segmenter.end_take()]


def activity_of(events: Iterable[Event], end: float) -> Reported:
    """Return the reports of the body's activity."""
    found = [event for event in events if isinstance(event, ActivityEvent) and event.channel == BODY]
    return Reported(found, end)


def bouts_of_performer(seed: int, seconds: float) -> tuple[Skeleton, Frames, list[Bout]]:
    """Return the built-in performer at 30 Hz, and the true bouts that lie between two rests of a second and more."""
    played = performance(seed, fps=RATE, seconds=seconds)
    rests = [cut for cut in played.cuts if cut.kind == "rest"]
    bouts = [
        Bout(begin.time, end.time)
        for begin, end in pairwise(rests)
        if begin.before in RESTS and end.after in RESTS and end.time + LAST <= played.frames.times[-1]
    ]
    return played.skeleton, played.frames, bouts


def is_exact(bout: Bout, reported: Reported) -> bool:
    """Return whether exactly one `moving` and one `resting` were reported of a bout."""
    states = [e.state for e in reported.events if bout.begin - AROUND <= e.start <= bout.end + AROUND]
    return states == ["moving", "resting"]


def quantiles(delays: Sequence[float]) -> str:
    """Return the median and the 90 % quantile of delays, s."""
    if not delays:
        return "  -       -   "
    median, most = np.quantile(delays, [0.5, 0.9])
    return f"{median:6.3f} {most:6.3f}"


def print_performer(demos: int, seconds: float) -> None:
    """Print the reports of the built-in performer."""
    exact = count = 0
    delays = defaultdict[str, list[float]](list)
    for seed in range(1, demos + 1):
        skeleton, frames, bouts = bouts_of_performer(seed, seconds)
        reported = activity_of(streamed(skeleton, frames, Settings(), RATE), float(frames.times[-1]))
        exact += sum(is_exact(bout, reported) for bout in bouts)
        count += len(bouts)
        for event in reported.events:
            delays[event.state].append(event.decided_time - event.start)
    print(f"the performer, {demos} seeds: {exact} of {count} bouts have one moving and one resting")
    for state, own in delays.items():
        print(f"  {state:<8} reported after {quantiles(own)} s (median, 90 %)")


def print_standing(minutes: float) -> None:
    """Print the false bouts of a standing performer with noise, for every level and preset."""
    for kind in ("white", "kinect"):
        played = performance(1, fps=RATE, moves=(f"stand:{60.0 * minutes:g}",), noise=NOISE, noise_kind=kind)
        chosen = [Settings(level=level) for level in LEVEL_NAMES]  # type: ignore[arg-type]
        chosen += [Settings.build(preset) for preset in PRESETS]
        for name, settings in zip((*LEVEL_NAMES, *PRESETS), chosen, strict=True):
            events = streamed(played.skeleton, played.frames, settings, RATE)
            count = len(activity_of(events, 0.0).events)
            print(f"{minutes:g} minutes of standing, 5 mm of {kind} noise, {name}: {count} events")
        events = streamed(played.skeleton, played.frames, Settings(limbs=True), RATE)
        limbs = [e for e in events if isinstance(e, ActivityEvent) and e.channel != BODY]
        print(f"{minutes:g} minutes of standing, 5 mm of {kind} noise, five limbs: {len(limbs)} events")


def print_labelled(takes: Sequence[Take]) -> None:
    """Print the bouts of labelled recordings, set by set."""
    flickers = 0
    seconds = 0.0
    groups = defaultdict[str, list[Take]](list)
    for take in takes:
        groups[take.group].append(take)
    for group, own in groups.items():
        bouts, brief, lasted = 0, 0, 0.0
        for take in own:
            frames = Frames(take.positions, take.times)
            events = streamed(take.skeleton, frames, Settings(level=take.level), take.fps)
            reported = activity_of(events, float(take.times[-1]))
            bouts += len(reported.bouts)
            brief += reported.flickers
            lasted += float(take.times[-1] - take.times[0])
        print(
            f"{group:<28}{bouts:>5} bouts, {brief} of them under {FLICKER:g} s, in {lasted / 60:.1f} minutes"
        )
        flickers, seconds = flickers + brief, seconds + lasted
    if seconds:
        print(f"flicker in 10 minutes of labelled recordings: {flickers / seconds * 600:.2f}")


def delays_of(events: Iterable[Event]) -> Iterable[tuple[str, float]]:
    """Yield which message of the body it is, and how late it is, s."""
    now = 0.0
    for event in events:
        if isinstance(event, KeyFrameEvent):
            now = event.decided_time
            if event.channel == BODY and event.status in ("candidate", "confirmed", "final"):
                kind = event.kind if event.status == "confirmed" else ""
                yield f"key_frame {event.status} {kind}".rstrip(), now - event.time
        elif isinstance(event, SegmentEvent) and event.channel == BODY and event.status != "withdrawn":
            yield f"segment {event.status}", now - event.end_time


def print_delays(takes: Sequence[Take], demos: int, seconds: float) -> None:
    """Print how late key frames and segments are, by level."""
    streams = [(take.skeleton, Frames(take.positions, take.times), take.fps) for take in takes]
    for seed in range(1, demos + 1):
        skeleton, frames, _ = bouts_of_performer(seed, seconds)
        streams.append((skeleton, frames, RATE))
    for level in LEVEL_NAMES:
        delays = defaultdict[str, list[float]](list)
        for skeleton, frames, fps in streams:
            segmenter = Segmenter(skeleton, Settings(level=level), fps=fps)  # type: ignore[arg-type]
            for message, delay in delays_of(segmenter.push(frames.positions, frames.times)):
                delays[message].append(delay)
        for message in sorted(delays):
            own = delays[message]
            print(f"{level:<9}{message:<28}{quantiles(own)} s, {len(own)} messages")


def print_holds(takes: Sequence[Take]) -> None:
    """Print the F1 of the ends of holds and rests."""
    for rests in get_args(RestsName):
        scores = []
        for take in takes:
            settings = Settings(level=take.level, rests=rests)
            events = streamed(take.skeleton, Frames(take.positions, take.times), settings, take.fps)
            found = sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "final")
            hits = len(match(found, take.cuts, take.tolerance))
            scores.append(2 * hits / max(1, len(found) + len(take.cuts)))
        print(f"holds, rests={rests}: F1 {np.mean(scores):.2f} {[round(score, 2) for score in scores]}")


def main() -> None:
    """Run the program."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("sets", nargs="*", type=Path, metavar="SET")
    parser.add_argument("--holds", type=Path, metavar="DIR")
    parser.add_argument("--demos", type=int, default=20, help="seeds of the built-in performer")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each")
    parser.add_argument("--minutes", type=float, default=10.0, help="of standing; 0 leaves it out")
    asked = parser.parse_args()
    takes = [take for folder in asked.sets for take in load_folder(folder)]
    print_performer(asked.demos, asked.seconds)
    print_labelled(takes)
    if asked.minutes > 0:
        print_standing(asked.minutes)
    print_delays(takes, asked.demos, asked.seconds)
    if asked.holds is not None:
        print_holds(load_folder(asked.holds))


if __name__ == "__main__":
    main()
