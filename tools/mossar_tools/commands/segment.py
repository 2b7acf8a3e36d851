"""`mossar segment`: whole recordings, offline."""

import glob
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from mossar_tools import values
from mossar_tools.console import LOGGER, Console, progress_of
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE, WRONG_USAGE, UsageError
from mossar_tools.options import (
    WIDTH,
    Begin,
    Body,
    Followed,
    Messages,
    MovesFile,
    Picture,
    Segmenting,
    Until,
    output,
)
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.sessions import check_pattern
from mossar_tools.wording import counted

if TYPE_CHECKING:
    from mossar_adapters.annotations.tiers import Tier
    from mossar_adapters.files.clips import Clip
    from mossar_adapters.files.loaded import LoadedRecording
    from mossar_stream import Result, Segmentation
    from mossar_tools.batch import Segmented

DESCRIPTION = """Segment whole recordings, offline, each with its own range: key frames, their hierarchy,
segments at a level. Without an option it prints a table. With --from and --until all outputs are of that part. Several
recordings are segmented in several processes. Unreadable recordings are named, the others are segmented, and the exit
status is 2."""
COMMON = (
    "--help",
    "--plot",
    "--csv",
    "--json",
    "--export",
    "--from",
    "--until",
    "--level",
    "--keep",
    "--repetitions",
    "--angles",
    "--steps",
    "--limbs",
    "--moves",
    "--follow",
    "--quiet",
)
EXAMPLES = """  mossar segment walk.bvh
  mossar segment walk.bvh --plot walk.png              also .svg and .pdf
  mossar segment long.bvh --from 600 --until 660 --csv part.csv --plot part.png --width 16
  mossar segment 86_01.amc --level cluster --csv segments.csv
  mossar segment take.c3d --keep 12 --json | jq '.segments[].state'
  mossar segment *.bvh --csv all.csv                   one table; --json writes a line for each recording
  mossar segment squats.bvh --repetitions --export squats.eaf
  mossar segment squats.bvh --repetitions --angles --csv angles.csv --curves curves.png
  mossar segment walk.c3d --steps --csv steps.csv      foot strikes and offs, cadence, stance and swing
  mossar segment take.c3d --export take.events.c3d     a copy with key frames as events
  mossar segment take.bvh --moves moves.json --limbs --plot take.png
  mossar segment squats.bvh --moves moves.json --follow squat --plot squats.png    how far each limb strays, each time
  mossar segment walk.bvh --level cluster --cut clips/
  mossar segment squats.bvh --repetitions --cut trials/ --of repetitions
  mossar segment ann_1_walk.bvh bo_1_walk.bvh --pattern '{person}_{session}_{trial}' --csv study.csv
  mossar segment 'demo:?seed=3' --plot demo.pdf --dark
"""

# Parts of a report whose numbers stand in the line of a recording, if there are several recordings.
_COUNTED = {
    "repetitions": "repetition",
    "followed": "followed move",
    "moves": "move",
    "poses": "pose",
    "steps": "step event",
}


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[tuple[str, ...], operand("FILE", "recordings, or demo:", "*")] = ()
    json: Annotated[
        str | None, Section("output"), output("all key frames with their strengths, and the segments")
    ] = None
    csv: Annotated[
        str | None,
        output("a row for each segment, repetition and move: when, which frames, what it is like"),
    ] = None
    export: Annotated[
        tuple[str, ...],
        Option(
            "a file for annotation programs; .eaf (ELAN), .TextGrid (Praat), .txt (Audacity), .vtt (WebVTT), .tsv (BIDS), .json and .xml "
            "(Label Studio: predictions, labelling interface), .etf (ELAN template); .c3d: a copy of a C3D recording with events",
            "FILE",
            repeatable=True,
        ),
    ] = ()
    video: Annotated[
        str | None, Option("for --export FILE.json and .xml: the video that Label Studio shows", "URL")
    ] = None
    cut: Annotated[
        str | None,
        Option("a clip of each segment, .bvh, .c3d, .trc or .npz, and a table of them, in a folder", "DIR"),
    ] = None
    of: Annotated[
        Literal["segments", "repetitions", "moves", "followed"],
        Option("kind of clips for --cut (default: segments)"),
    ] = "segments"
    person: Annotated[
        str | None,
        Option("a column of the tables: the person in the recordings", "NAME"),
    ] = None
    session: Annotated[
        str | None, Option("a column of the tables: the session of the recordings", "NAME")
    ] = None
    pattern: Annotated[
        str | None,
        Option(
            "columns of the tables from the files' names: '{person}_{session}_{trial}' for ann_2_walk.c3d",
            "TEXT",
        ),
    ] = None
    angles: Annotated[
        bool,
        Option(
            "with --repetitions: the range of knees, hips, elbows and other joints in each repetition, degrees"
        ),
    ] = False
    curves: Annotated[
        str | None, Option("the angles of every frame: a table .csv, or a picture .png, .svg, .pdf", "FILE")
    ] = None
    picture: Picture = Picture()
    width: Annotated[
        float, Option(f"of the picture (default: {WIDTH:g}); a wide one shows more", "INCHES", values.inches)
    ] = WIDTH
    begin: Annotated[Begin, Section("a part of a recording")] = None
    until: Until = None
    plot_to: Annotated[float | None, Option("former name of --until", "S", values.seconds, flag="to")] = None
    moves: MovesFile = None
    follow: Followed = ()
    keep: Annotated[int | None, Option("keep the K strongest key frames", "K", values.whole)] = None
    segmentation: Segmenting = Segmenting()
    body: Body = Body()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    settings = options.segmentation.settings(*options.sources, range="file")
    files = _files(options)
    options = _until(options)
    if options.picture.plot is None and options.width != WIDTH:
        raise UsageError("--width is of a picture; add --plot FILE")
    if options.of != "segments" and options.cut is None:
        raise UsageError("--of says what --cut DIR cuts; add --cut")
    if options.of == "repetitions" and not settings.repetitions:
        raise UsageError("--of repetitions needs --repetitions")
    if options.of == "moves" and options.moves is None:
        raise UsageError("--of moves needs --moves FILE")
    if options.of == "followed" and not options.follow:
        raise UsageError("--of followed needs --moves FILE --follow NAMES")
    check_pattern(options)
    if options.angles and not settings.repetitions:
        raise UsageError("--angles are of repetitions; add --repetitions")
    outputs = Outputs.of(options)
    if len(files) == 1:
        return _one(files[0], options, outputs, console)
    if outputs.picture is not None:
        raise UsageError("--plot draws one recording; name one")
    if outputs.exports or outputs.clips is not None or outputs.curves is not None:
        raise UsageError("--export, --cut and --curves are of one recording; name one")
    return _several(files, options, outputs, console)


def _until(options: Options) -> Options:
    """Return the options with the value of `--to`, the former name of `--until`, as `until`.

    Raises:
        UsageError: If both are given.
    """
    if options.plot_to is None:
        return options
    if options.until is not None:
        raise UsageError("--to is the former name of --until; give one of them")
    LOGGER.warning("--to is called --until now; the next release has no --to here")
    return msgspec.structs.replace(options, until=options.plot_to, plot_to=None)


def _files(options: Options) -> list[str]:
    """Return the recordings, with the patterns expanded that the shell left.

    Raises:
        UsageError: If there is none.
    """
    for name in ("json", "csv"):
        place = getattr(options, name)
        if not options.sources and place not in {None, "-"}:
            raise UsageError(
                f"--{name} {place}: which recording? Name it first: mossar segment {place} --{name}"
            )
    found = []
    for name in options.sources:
        pattern = glob.has_magic(name) and not Path(name).exists()
        matching = sorted(glob.glob(name)) if pattern else []  # noqa: PTH207 - in any folder, as in the shell
        found += matching or [name]
    if not found:
        raise UsageError("which recording? A file, several, or demo: (see mossar segment --help)")
    return found


def _one(file: str, options: Options, outputs: Outputs, console: Console) -> int:
    from mossar_tools.batch import report_of, rows_of, segment_whole

    loaded, result, chosen = segment_whole(
        file,
        options,
        lambda share: console.progress(share, f"reading {file}"),
        lambda: progress_of(f"segmenting {file}"),
        curves=outputs.picture is not None,
    )
    console.clear()
    outputs.write_json(report_of(options, loaded, result, chosen), console)
    outputs.write_csv(rows_of(options, loaded, result, chosen), console)
    write = outputs.reading(console, quiet=options.messages.quiet)
    if write is not None:
        from mossar_tools.tables import segmentation_table

        for line in segmentation_table(
            loaded, result, chosen, console, angles=options.angles, keep=options.keep
        ):
            write(line)
    if outputs.curves is not None:
        from mossar_tools.angle_curves import write_curves

        write_curves(outputs.curves, loaded, result, palette(dark=options.picture.dark))
        console.say(f"written: {outputs.curves}")
    if outputs.exports:
        _export(file, options, outputs, loaded, result, chosen, console)
    if outputs.clips is not None:
        from mossar_adapters.files.clips import write_clips

        clips, rows = _clips(options, loaded, result, chosen)
        count = write_clips(
            outputs.clips, loaded, clips, rows, options.body.reading(again=options.picture.force)
        )
        console.say(f"written: {count} clips in {outputs.clips}")
    if outputs.picture is not None:
        from mossar_tools.follow_plot import draw_followed
        from mossar_tools.plot import draw

        console.status("drawing ...", now=True)
        colours = palette(dark=options.picture.dark)
        if result.followed:
            draw_followed(outputs.picture, loaded.name, result.followed, colours, options.width)
        else:
            draw(outputs.picture, loaded, result, chosen, colours, options.keep, width=options.width)
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _clips(
    options: Options, loaded: "LoadedRecording", result: "Result", chosen: "Segmentation"
) -> "tuple[list[Clip], list[dict[str, Any]]]":
    """Return the clips that `--of` selects, and the row of each."""
    from mossar_adapters.files.clips import Clip, clips_of_segments
    from mossar_tools.batch import rows_of, rows_of_segments

    if options.of == "segments":
        return clips_of_segments(chosen.segments), rows_of_segments(loaded, chosen)
    state = options.of.removesuffix("s")
    rows = [row for row in rows_of(options, loaded, result, chosen) if row["state"] == state]
    if not rows:
        missing = "performances" if options.of == "followed" else options.of
        LOGGER.warning("%s: there are no %s to be cut", loaded.name, missing)
    last = len(loaded.times) - 1
    ends = [(row["start_frame"], min(row["end_frame"], last) + 1) for row in rows]
    names = [_clip_name(row) for row in rows]
    return [Clip(*span, name) for span, name in zip(ends, names, strict=True)], rows


def _clip_name(row: "dict[str, Any]") -> str:
    """Return the name of the clip of a move, a performance or a repetition."""
    of = row.get("name") or row["channel"]
    return str(of) if row["state"] == "move" else f"{of}_{row['count']}"


def _export(
    file: str,
    options: Options,
    outputs: Outputs,
    loaded: "LoadedRecording",
    result: "Result",
    chosen: "Segmentation",
    console: Console,
) -> None:
    from mossar_adapters.annotations.c3d import is_c3d, write_c3d_events
    from mossar_adapters.annotations.label_studio import is_label_studio, write_label_studio
    from mossar_adapters.annotations.writing import write_annotations

    console.status("segmenting at the other levels ...", now=True)
    tiers = _tiers(file, options, loaded, result, chosen)
    duration = float(loaded.times[-1] - loaded.begin) if len(loaded.times) else 0.0
    console.clear()
    for path in outputs.exports:
        if is_c3d(path):
            added = write_c3d_events(loaded.name, path, tiers)
            console.say(f"written: {path}, with {added} events more than {loaded.name}")
            continue
        if is_label_studio(path):
            length = float(loaded.times[-1] - loaded.times[0]) if len(loaded.times) else 0.0
            fps = loaded.fps or (len(loaded.times) - 1) / max(length, 1e-9)
            write_label_studio(path, tiers, loaded.times, loaded.positions, options.video, fps, loaded.begin)
        else:
            write_annotations(path, tiers, duration)
        console.say(f"written: {path}")


def _tiers(
    file: str, options: Options, loaded: "LoadedRecording", result: "Result", chosen: "Segmentation"
) -> "list[Tier]":
    """Return the tiers for annotators: the chosen level, the other named ones, moves, repetitions and limbs."""
    from mossar_adapters.annotations.tiers import (
        follow_tiers,
        key_frame_tier,
        move_tier,
        of_limb,
        repetition_tier,
        segment_tier,
        step_tier,
    )
    from mossar_stream import LEVEL_NAMES, segment_recording
    from mossar_tools.excerpt import chosen_of

    origin = loaded.begin
    level = result.settings.level if options.keep is None else None
    tiers = [segment_tier(chosen.segments, level, origin), key_frame_tier(chosen.key_frames, origin)]
    for other in LEVEL_NAMES if isinstance(level, str) else ():
        if other != level:
            settings = msgspec.structs.replace(options.segmentation, level=other).settings(file, range="file")
            settings = settings.replace(limbs=False, phase=False, repetitions=False, steps=False)
            again = segment_recording(
                loaded.positions,
                loaded.fps,
                loaded.skeleton,
                settings,
                times=loaded.times,
                takes=True,
                on_progress=progress_of(f"segmenting {loaded.name} at level {other}"),
            )
            tiers.append(segment_tier(again.segments, other, origin))
    tiers += [move_tier(result.moves, origin)] if result.moves else []
    tiers += follow_tiers(result.followed, origin)
    tiers += [step_tier(result.steps, origin)] if result.settings.steps else []
    if result.settings.repetitions:
        tiers.append(repetition_tier(result.repetitions, origin))
        tiers += [
            of_limb(name, repetition_tier(own.repetitions, origin)) for name, own in result.limbs.items()
        ]
    for name, own in result.limbs.items():
        tiers.append(of_limb(name, segment_tier(chosen_of(own, options.keep).segments, None, origin)))
    return tiers


def _found(done: "Segmented") -> Iterator[str]:
    """Yield the counts of a recording, those of moves, repetitions and steps first."""
    for name, one in _COUNTED.items():
        if name in done.report:
            yield counted(len(done.report[name]), one)
    yield counted(done.frames, "frame")
    yield counted(len(done.report["key_frames"]), "key frame")
    yield counted(len(done.report["segments"]), "segment")


def _several(files: list[str], options: Options, outputs: Outputs, console: Console) -> int:
    from mossar_tools.batch import columns_of, segment_all

    def shown(results: "Iterator[Segmented]") -> "Iterator[Segmented]":
        for number, done in enumerate(results, 1):
            console.progress(number / len(files), f"{number} of {len(files)}: {done.name}")
            yield done

    bad = 0
    write_line = outputs.reading(console, quiet=options.messages.quiet)
    with (
        outputs.json_lines(console) as write_json,
        outputs.csv_rows(columns_of(options), console) as write_csv,
    ):
        for done in shown(segment_all(files, options)):
            if done.error:
                bad += 1
                LOGGER.error("%s", done.error)
                continue
            write_json(done.report)
            write_csv(done.rows)
            if write_line is not None:
                write_line(f"{done.name}: {', '.join(_found(done))}")
    console.clear()
    if bad:
        console.say(f"mossar: {bad} of {len(files)} recordings could not be segmented")
    return WRONG_USAGE if bad else DONE
