"""Batch: whole recordings, in turn or in several processes; an unreadable one does not stop the others.

Each recording is segmented in a process of a pool, so that a crash (a damaged file, too little memory) costs that
recording only. Results come in the order of the files, however long each takes.
"""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from mossar_adapters.files.loaded import LoadedRecording, OnProgress
from mossar_adapters.pipeline.outcome import GUESSED_LIMBS, WITHOUT_LIMBS
from mossar_adapters.segment_csv import (
    COLUMNS,
    COUNTED,
    FOLLOWED,
    NAMED,
    Ending,
    event_row,
    segment_row,
    stretch_row,
)
from mossar_adapters.spans import Spanning
from mossar_stream import (
    BODY,
    MossarError,
    RangeOfMotion,
    RepetitionEvent,
    Result,
    Segmentation,
    Step,
    gait_of,
    joint_angles,
    limbs_are_guessed,
    ranges_of_motion,
    segment_recording,
    step_table,
)
from mossar_tools.console import LOGGER
from mossar_tools.excerpt import chosen_of
from mossar_tools.loaded_recording import load_recording
from mossar_tools.moves_file import moves_to_follow
from mossar_tools.sessions import columns_of_names, values_of_name

if TYPE_CHECKING:
    from mossar_tools.commands.segment import Options

# Further columns with angles.
BENT = (
    "angle",
    "minimum",
    "maximum",
    "range",
    "up",
    "hold",
    "down",
    "asymmetry",
)
STEPPED = ("step_time", "stance", "swing", "cadence", "step_length")  # and with steps
AHEAD = 4  # recordings of each process that are under way or wait to be written
FEW = 3  # recordings for which a second process would only cost its start


class Segmented(msgspec.Struct, frozen=True):
    """The outcome of one recording.

    Args:
        name: The file.
        report: As `--json` has it.
        rows: As `--csv` has them.
        frames: Of the recording.
        error: Why it could not be segmented; then there is no report.
    """

    name: str
    report: dict[str, Any] = {}  # msgspec copies it
    rows: list[dict[str, Any]] = []
    frames: int = 0
    error: str = ""


def segment_whole(
    file: str,
    options: "Options",
    on_progress: OnProgress = lambda _: None,
    progress: Callable[[], Callable[[float], None]] | None = None,
    *,
    curves: bool = False,
) -> tuple[LoadedRecording, Result, Segmentation]:
    """Return a recording, its result, and the wanted level.

    Args:
        file: Its path, or demo:.
        options: Which part of it, and how to segment it.
        on_progress: Gets the share that is read.
        progress: Called as segmentation begins; returns a function of the share that is done.
        curves: Whether to keep the velocity curve.

    Raises:
        MossarError: If it cannot be read, or the options do not fit it.
    """
    settings = options.segmentation.settings(file, range="file")
    moves, follow = moves_to_follow(options.moves, options.follow)
    reading = options.body.reading(again=options.picture.force)
    loaded = load_recording(file, reading, on_progress, begin=options.begin, until=options.until)
    if settings.steps and settings.up == "auto":
        settings = settings.replace(up=loaded.up)
    result = segment_recording(
        loaded.positions,
        loaded.fps,
        loaded.skeleton,
        settings,
        times=loaded.times,
        curves=curves,
        moves=moves,
        follow=follow,
        takes=True,
        on_progress=None if progress is None else progress(),
    )
    _warn_of_dropped_frames(loaded, result.takes)
    if is_divided(loaded, result):
        spans = ", ".join(
            f"{one['start_time']:.2f}-{one['end_time']:.2f} s" for one in takes_table(loaded, result)
        )
        LOGGER.info("%s: a performer is seen in %s", loaded.name, spans)
    if settings.limbs and not result.limbs:
        LOGGER.warning("%s: there are no limbs, as %s", loaded.name, WITHOUT_LIMBS)
    elif settings.limbs is True and limbs_are_guessed(loaded.skeleton):
        LOGGER.info("%s: %s", loaded.name, GUESSED_LIMBS)
    return loaded, result, chosen_of(result, options.keep)


def is_divided(loaded: LoadedRecording, result: Result) -> bool:
    """Return whether a recording has several takes, or one that does not cover it all."""
    return bool(result.takes) and result.takes != [(0, len(loaded.times) - 1)]


def takes_table(loaded: LoadedRecording, result: Result) -> list[dict[str, float]]:
    """Return the first and last frame of each take, and their times, s."""
    return [
        {
            "start_frame": begin,
            "end_frame": end,
            "start_time": float(loaded.times[begin]),
            "end_time": float(loaded.times[end]),
        }
        for begin, end in result.takes
    ]


def _warn_of_dropped_frames(loaded: LoadedRecording, takes: Sequence[tuple[int, int]]) -> None:
    """Warn of a recording without any joint, or with frames that are dropped."""
    times, late = loaded.times, 0
    for begin, end in takes:
        part = times[begin : end + 1]
        late += int(np.count_nonzero(part[1:] <= np.fmax.accumulate(part)[:-1]))
    if late:
        LOGGER.warning(
            "%s: %d of %d frames come out of order and are left out", loaded.name, late, len(times)
        )
    if len(times) and np.isnan(loaded.positions).all():
        LOGGER.warning("%s: no performer: every joint is missing in all frames", loaded.name)


def report_of(
    options: "Options", loaded: LoadedRecording, result: Result, chosen: Segmentation
) -> dict[str, Any]:
    """Return the `--json` output of a recording."""
    report: dict[str, Any] = {
        "v": 1,
        "recording": loaded.name,
        **values_of_name(options, loaded.name),
        "fps": loaded.fps,
        "level": options.segmentation.settings().level if options.keep is None else None,
        "key_frames": result.key_frames,
        "segments": chosen.segments,
    }
    if is_divided(loaded, result):
        report["takes"] = takes_table(loaded, result)
    if options.moves is not None:
        report["moves"] = result.moves
        report["poses"] = result.poses
    if options.follow:
        report["followed"] = result.followed
    if result.settings.repetitions:
        report["repetitions"] = result.repetitions
    if options.angles:
        report["angles"] = motion_of(loaded, result)
    if result.settings.steps:
        report["steps"] = result.steps
        report["gait"] = gait_of(result.steps)
    if result.settings.limbs:
        report["limbs"] = {
            name: {
                "key_frames": own.key_frames,
                "segments": chosen_of(own, options.keep).segments,
            }
            | ({"repetitions": own.repetitions} if result.settings.repetitions else {})
            for name, own in result.limbs.items()
        }
    return report


def rows_of(
    options: "Options", loaded: LoadedRecording, result: Result, chosen: Segmentation
) -> list[dict[str, Any]]:
    """Return the rows of `--csv` of a recording: segments, those of the body first, then repetitions, then moves."""
    rows = _rows_of_parts(options, loaded, result, chosen)
    events: list[Spanning] = [*repetitions_of(result), *result.moves, *result.poses, *result.followed]
    rows += [event_row(loaded.name, event, loaded.performer, loaded.times) for event in events]
    rows += [_row_of_angle(loaded, own) for own in (motion_of(loaded, result) if options.angles else ())]
    rows += [_row_of_step(loaded, event) for event in step_table(result.steps)]
    blank = dict.fromkeys(columns_of(options), "") | values_of_name(options, loaded.name)
    return [blank | row for row in rows]


def columns_of(options: "Options") -> tuple[str, ...]:
    """Return the heading of `--csv`."""
    counted: tuple[str, ...] = COUNTED if options.segmentation.settings().repetitions else ()
    named = () if options.moves is None else NAMED
    counted += BENT if options.angles else ()
    counted += ("count",) if options.follow and "count" not in counted else ()
    return (
        COLUMNS[:1]
        + columns_of_names(options)
        + COLUMNS[1:]
        + counted
        + named
        + (FOLLOWED if options.follow else ())
        + (STEPPED if options.segmentation.settings().steps else ())
    )


def repetitions_of(result: Result) -> list[RepetitionEvent]:
    """Return the repetitions of the body and those of limbs."""
    return [*result.repetitions, *(event for own in result.limbs.values() for event in own.repetitions)]


def motion_of(loaded: LoadedRecording, result: Result) -> list[RangeOfMotion]:
    """Return the range of each angle in each repetition of the body and of limbs."""
    angles = joint_angles(loaded.positions, loaded.skeleton, loaded.up)
    return ranges_of_motion(angles, loaded.times, repetitions_of(result))


def _row_of_angle(loaded: LoadedRecording, own: RangeOfMotion) -> dict[str, Any]:
    row = _row_of(loaded, (own.start, own.end), "range", own.channel)
    values = {name: _shown(getattr(own, name)) for name in BENT if name != "angle"}
    return row | {"angle": own.angle, "count": own.count} | values


def _row_of_step(loaded: LoadedRecording, step: Step) -> dict[str, Any]:
    """Return the row of a step, from its strike to the next one of the same foot."""
    end = step.start if step.end is None else step.end
    row = _row_of(loaded, (step.start, end), "step", f"{step.side}_foot")
    values = {name: _shown(getattr(step, name)) for name in STEPPED}
    return row | {"end": "" if step.end is None else row["end"]} | values


def _row_of(loaded: LoadedRecording, ends: tuple[float, float], state: str, channel: str) -> dict[str, Any]:
    return stretch_row(loaded.name, loaded.performer, 0, ends, state, channel=channel, times=loaded.times)


def _shown(value: float | None) -> str:
    return "" if value is None else f"{value:.4f}"


def _rows_of_parts(
    options: "Options", loaded: LoadedRecording, result: Result, chosen: Segmentation
) -> list[dict[str, Any]]:
    channels = {BODY: chosen} | {name: chosen_of(own, options.keep) for name, own in result.limbs.items()}
    return [row for channel, found in channels.items() for row in rows_of_segments(loaded, found, channel)]


def rows_of_segments(
    loaded: LoadedRecording, found: Segmentation, channel: str = BODY
) -> list[dict[str, Any]]:
    """Return a row for each segment of the body or of a limb."""
    endings = {key.frame: Ending(key.kind, key.strength) for key in found.key_frames}
    return [
        segment_row(loaded.name, loaded.performer, 0, part, endings.get(part.end_frame, Ending()), channel)
        for part in found.segments
    ]


def segment_all(files: Sequence[str], options: "Options") -> Iterator[Segmented]:
    """Yield the outcome of each recording, in their order."""
    processes = min(os.cpu_count() or 1, len(files) // FEW)
    if processes < 2:
        yield from (_segmented(options, name) for name in files)
        return
    waiting = list(files)
    while waiting:
        try:
            for done in _in_processes([*waiting], options, processes):
                waiting.pop(0)
                yield done
        except BrokenProcessPool:
            # The oldest is not to blame for certain: by itself it shows whether it is.
            yield _alone(waiting.pop(0), options)


def _in_processes(files: Sequence[str], options: "Options", processes: int) -> Iterator[Segmented]:
    under_way: list[Future[Segmented]] = []
    rest = iter(files)
    with ProcessPoolExecutor(processes, get_context("spawn"), _leave_ctrl_c_to_the_parent) as pool:
        try:
            while True:
                for _, name in zip(range(processes * AHEAD - len(under_way)), rest, strict=False):
                    under_way.append(pool.submit(_segmented, options, name))
                if not under_way:
                    return
                yield under_way.pop(0).result()
        finally:
            pool.shutdown(cancel_futures=True)


def _alone(name: str, options: "Options") -> Segmented:
    try:
        return next(_in_processes([name], options, 1))
    except BrokenProcessPool:
        return Segmented(name, error=f"{name}: the process that segments it died; too little memory?")


def _leave_ctrl_c_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _segmented(options: "Options", name: str) -> Segmented:
    try:
        loaded, result, chosen = segment_whole(name, options)
    except MossarError as error:
        return Segmented(name, error=str(error))
    report = msgspec.to_builtins(report_of(options, loaded, result, chosen))
    return Segmented(name, report, rows_of(options, loaded, result, chosen), len(loaded.times))
