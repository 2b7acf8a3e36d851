"""Tables: results for people to read in a terminal."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import FollowEvent, RangeOfMotion, Result, Segmentation, gait_of
from mossar_tools.batch import motion_of
from mossar_tools.console import Console
from mossar_tools.wording import judged


def segmentation_table(
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    console: Console,
    *,
    angles: bool = False,
) -> Iterator[str]:
    """Yield the lines of a table of segments.

    Args:
        whole: The recording.
        result: What was found in it.
        chosen: The level to show.
        console: Tells what can be printed.
        angles: Whether to say how far joints bend in repetitions.
    """
    rate = f" at {whole.fps:g} Hz" if whole.fps else ""
    length = float(np.nanmax(whole.times) - np.nanmin(whole.times)) if len(whole.times) else 0.0
    piece = f" from {whole.times[0]:g} to {whole.times[-1]:g} s" if whole.outside != (0, 0) else ""
    yield f"{Path(whole.name).name}{piece} · {len(whole.times)} frames, {length:.1f} s{rate} · {len(whole.skeleton)} joints"
    yield f"{len(chosen.key_frames)} of {len(result.key_frames)} key frames stand"
    if result.settings.repetitions:
        yield from _repetitions("", result)
    for name, own in result.limbs.items():
        if own.repetitions:
            yield from _repetitions(f" of {name.replace('_', ' ')}", own)
    if angles:
        yield from _angle_lines(whole, result)
    if result.settings.steps:
        yield from _gait_lines(result)
    for move in result.moves:
        yield f"{move.name}, {move.limb.replace('_', ' ')}, from {move.start:.2f} s to {move.end:.2f} s"
    yield from _followed(result)
    yield ""
    heading = f"{'start':>10}{'end':>10}{'length':>10}  {'state':<9}{'ended by':<10}{'strength':>9}  most active joints"
    yield console.colour(heading, "2")
    ends = {key.frame: key for key in chosen.key_frames}
    for part in chosen.segments:
        key = ends.get(part.end_frame)
        ended = f"{key.kind:<10}{key.strength:>9.2f}" if key else f"{'the end':<10}{'':>9}"
        seconds = part.end_time - part.start_time
        row = f"{part.start_time:>8.2f} s{part.end_time:>8.2f} s{seconds:>8.2f} s  {part.state:<9}{ended}"
        yield f"{row}  {', '.join(part.active_joints[:3])}"


def _followed(result: Result) -> Iterator[str]:
    """Yield how often each followed move was done, and how each performance of it went."""
    own: dict[str, list[FollowEvent]] = {}
    for event in result.followed:
        own.setdefault(event.name, []).append(event)
    for name, events in own.items():
        yield f"{name}: {len(events)} done"
        for event in events:
            score = "" if event.score is None else f", score {event.score:.2f}"
            yield f"  {event.count:>3}  from {event.start:.2f} s to {event.time:.2f} s, {judged(event)}{score}"


def _gait_lines(result: Result) -> Iterator[str]:
    """Yield what the steps of a recording have in common."""
    gait = gait_of(result.steps)
    pace = f", {gait.cadence:.1f} a minute" if gait.cadence else ""
    yield f"{gait.steps} steps{pace}"
    for name in ("step_time", "stance", "swing"):
        left, right = (getattr(gait, name)[side] for side in ("left", "right"))
        if left is not None and right is not None:
            uneven = gait.asymmetry[name]
            text = "" if uneven is None else f", asymmetry {uneven:.0f} %"
            yield f"{name.replace('_', ' ')}: left {left:.2f} s, right {right:.2f} s{text}"


def _repetitions(of: str, result: Result) -> Iterator[str]:
    """Yield how many repetitions there are, how quick they are, and a line for each."""
    tempos = [event.tempo for event in result.repetitions if event.tempo is not None]
    pace = f", {np.median(tempos):.1f} a minute" if tempos else ""
    yield f"{len(result.repetitions)} repetitions{of}{pace}"
    for event in result.repetitions:
        start, end = event.start or 0.0, event.end or 0.0  # what is counted has both
        tempo = "" if event.tempo is None else f", {event.tempo:.1f} a minute"
        yield f"  {event.total:>3}  from {start:.2f} s to {end:.2f} s, {event.count} in a row{tempo}"


def _angle_lines(whole: LoadedRecording, result: Result) -> Iterator[str]:
    """Yield the median range of each angle over the repetitions, the largest first."""
    found: dict[str, list[RangeOfMotion]] = {}
    for own in motion_of(whole, result):
        found.setdefault(own.angle, []).append(own)
    middle = {name: float(np.median([one.range for one in own])) for name, own in found.items()}
    for name in sorted(found, key=lambda name: -middle[name]):
        low, high = (
            float(np.median([getattr(one, end) for one in found[name]])) for end in ("minimum", "maximum")
        )
        uneven = [one.asymmetry for one in found[name] if one.asymmetry is not None]
        text = f", asymmetry {np.median(uneven):.0f} %" if uneven else ""
        words = name.replace("_", " ")
        yield f"{words}: {low:.0f} to {high:.0f} degrees, range {middle[name]:.0f} in the median repetition{text}"
