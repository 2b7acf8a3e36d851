"""Tables: results for people to read in a terminal."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream import FollowEvent, PoseEvent, RangeOfMotion, Result, Segmentation, gait_of
from mossar_tools.batch import motion_of
from mossar_tools.console import Console
from mossar_tools.wording import counted, judged, strongest

# Key frames in a reader's words.
_ENDED: Final = {
    "onset": "start",
    "offset": "stop",
    "minimum": "slow point",
}
_DISPENSABLE: Final = ("ended by", "length")  # columns in the order in which they give way
_JOINTS: Final = 12  # columns that the first joint should have
_WIDE: Final = 1 << 16  # columns where nothing limits a line
_EARLY: Final = 60.0  # s; a recording whose clock begins earlier keeps it


def segmentation_table(
    whole: LoadedRecording,
    result: Result,
    chosen: Segmentation,
    console: Console,
    *,
    angles: bool = False,
    keep: int | None = None,
) -> Iterator[str]:
    """Yield the results of a recording: the answers first, then the table of segments. Lines fit the terminal.

    Args:
        whole: The recording.
        result: Its result.
        chosen: The level to show.
        console: Tells whether symbols can be printed.
        angles: Whether to add the ranges of joints in repetitions.
        keep: Wanted number of key frames, if not a level.
    """
    zero = _zero(whole)
    for line in (
        *_heading(whole, zero),
        *answers(whole, result, zero, angles=angles),
        "",
        _of_level(result, chosen, keep),
    ):
        yield from console.fold(line) if line else [""]
    yield ""
    yield from _segment_lines(chosen, zero, console)


def answers(
    whole: LoadedRecording, result: Result, zero: float = 0.0, *, angles: bool = False
) -> Iterator[str]:
    """Yield the counts, moves, performances, poses and measures.

    Args:
        whole: The recording.
        result: Its result.
        zero: Time of its clock that counts as 0, s.
        angles: Whether to add the ranges of joints in repetitions.
    """
    if result.settings.repetitions:
        yield from _repetitions("", result, zero)
    for name, own in result.limbs.items():
        if own.repetitions:
            yield from _repetitions(f" of {name.replace('_', ' ')}", own, zero)
    yield from _followed(result, zero)
    followed = {event.name for event in result.followed}  # which has its own lines
    for move in (move for move in result.moves if move.name not in followed):
        yield f"{move.name}, {move.limb.replace('_', ' ')}, {_span(move.start, move.end, zero)}"
    yield from _poses(result, zero)
    if result.settings.steps:
        yield from _gait_lines(result)
    if angles:
        yield from _angle_lines(whole, result)


def _zero(whole: LoadedRecording) -> float:
    """Return the time of a recording's clock that is shown as 0 s: that of its begin, if it is a computer's clock."""
    return 0.0 if 0 <= whole.begin < _EARLY else whole.begin


def _span(start: float, end: float, zero: float) -> str:
    return f"from {start - zero:.2f} s to {end - zero:.2f} s"


def _heading(whole: LoadedRecording, zero: float) -> Iterator[str]:
    rate = f" at {whole.fps:g} Hz" if whole.fps else ""
    length = float(np.nanmax(whole.times) - np.nanmin(whole.times)) if len(whole.times) else 0.0
    piece = f" from {whole.times[0]:g} to {whole.times[-1]:g} s" if whole.outside != (0, 0) else ""
    frames = counted(len(whole.times), "frame")
    yield f"{Path(whole.name).name}{piece} · {frames}, {length:.1f} s{rate} · {counted(len(whole.skeleton), 'joint')}"
    if zero:
        yield f"times count from the start, which is {zero:.3f} s of the recording's clock (--from, --until, --csv)"


def _of_level(result: Result, chosen: Segmentation, keep: int | None) -> str:
    """Return the number of segments, and the way it was chosen."""
    kept, known = len(chosen.key_frames), len(result.key_frames)
    level = result.settings.level
    where = f"level {level}" if isinstance(level, str) else f"strength {level:g}"
    how = "--keep" if keep is not None else where
    divided = f"divided by {strongest(kept, known)}" if known else "no key frames"
    return f"{counted(len(chosen.segments), 'segment')}, {divided} ({how}):"


def _segment_lines(chosen: Segmentation, zero: float, console: Console) -> Iterator[str]:
    """Yield the table of segments, with the columns that there is room for."""
    room = console.room() or _WIDE
    columns = {"start": ">9", "end": ">10", "length": ">9", "state": "<9", "ended by": "<12"}
    for name in _DISPENSABLE:
        if sum(int(width[1:]) + 1 for width in columns.values()) + _JOINTS > room:
            columns.pop(name)
    titles = dict(zip(columns, columns, strict=True))
    yield console.colour(_row(titles, columns, ["most active joints"], room), "2")
    ends = {key.frame: key for key in chosen.key_frames}
    for part in chosen.segments:
        key = ends.get(part.end_frame)
        cells = {
            "start": f"{part.start_time - zero:.2f} s",
            "end": f"{part.end_time - zero:.2f} s",
            "length": f"{part.end_time - part.start_time:.2f} s",
            "state": part.state,
            "ended by": _ENDED[key.kind] if key else "the end",
        }
        yield _row(cells, columns, part.active_joints[:3], room)


def _row(cells: Mapping[str, str], columns: Mapping[str, str], joints: Sequence[str], room: int) -> str:
    """Return a line of the table with as many joints as fit."""
    text = "".join(f"{' ' * (width[0] == '<') * 2}{cells[name]:{width}}" for name, width in columns.items())
    for name in joints:
        separator = "" if name == joints[0] else ", "
        if len(text) + len(separator) + len(name) > room:
            break
        text += separator + name
    return text.rstrip()[:room]


def _followed(result: Result, zero: float) -> Iterator[str]:
    """Yield the count of each followed move, and a line for each performance."""
    own: dict[str, list[FollowEvent]] = {}
    for event in result.followed:
        own.setdefault(event.name, []).append(event)
    for name, events in own.items():
        yield f"{name}: {len(events)} done"
        for event in events:
            score = "" if event.score is None else f", score {event.score:.2f}"
            yield f"  {event.count:>3}  {_span(event.start, event.time, zero)}, {judged(event)}{score}"


def _poses(result: Result, zero: float) -> Iterator[str]:
    """Yield the count, the durations and the deviations of each pose."""
    own: dict[str, list[PoseEvent]] = {}
    for event in result.poses:
        own.setdefault(event.name, []).append(event)
    for name, events in own.items():
        yield f"{name}: taken {counted(len(events), 'time')}"
        for number, event in enumerate(events, 1):
            joint = event.joint.replace("_", " ")
            yield (
                f"  {number:>3}  from {event.start - zero:.2f} s, for {event.seconds:.1f} s, "
                f"{event.deviation:.0f}° off, most at {joint}"
            )


def _gait_lines(result: Result) -> Iterator[str]:
    """Yield the medians of the steps of a recording."""
    gait = gait_of(result.steps)
    pace = f", {gait.cadence:.1f} a minute" if gait.cadence else ""
    yield f"{counted(gait.steps, 'step')}{pace}"
    for name in ("step_time", "stance", "swing"):
        left, right = (getattr(gait, name)[side] for side in ("left", "right"))
        if left is not None and right is not None:
            uneven = gait.asymmetry[name]
            text = "" if uneven is None else f", asymmetry {uneven:.0f} %"
            yield f"{name.replace('_', ' ')}: left {left:.2f} s, right {right:.2f} s{text}"


def _repetitions(of: str, result: Result, zero: float) -> Iterator[str]:
    """Yield the number and the tempo of repetitions, and a line for each."""
    tempos = [event.tempo for event in result.repetitions if event.tempo is not None]
    pace = f", {np.median(tempos):.1f} a minute" if tempos else ""
    yield f"{counted(len(result.repetitions), 'repetition')}{of}{pace}"
    for event in result.repetitions:
        start, end = event.start or 0.0, event.end or 0.0  # a counted repetition has both
        tempo = "" if event.tempo is None else f", {event.tempo:.1f} a minute"
        yield f"  {event.total:>3}  {_span(start, end, zero)}, {event.count} in a row{tempo}"


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
