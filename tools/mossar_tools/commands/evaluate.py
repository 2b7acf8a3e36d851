"""`mossar evaluate`: accuracy against labelled recordings."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec

from mossar_adapters.address import parse_url
from mossar_stream import Settings
from mossar_tools.console import Console
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE, UsageError
from mossar_tools.evaluation.takes import Take
from mossar_tools.options import LabelledSegmenting, Messages, Picture, output
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.values import count, factors, share

DESCRIPTION = """Compare key frames with the true cuts of labelled recordings: Mossar by parts and similarities,
streaming and offline, and by chance.

A labelled folder has a file walk.json beside each recording walk.bvh:
  {"recording": "walk.bvh", "fps": 120, "tolerance_s": 0.25, "level": "motion",
   "cuts": [[500, 550, 600], 1150, 1980]}
Cuts are frames from 0, as [earliest, middle, latest] or one number; with "cuts_in": "seconds" they are seconds since the
first frame. level is posture, motion or cluster. Instead of "cuts" there may be "judges": a list of frames for each
person who set cuts. "skeleton" names the .asf of an .amc. Instead of walk.json there may be a file that a
person annotated or corrected: walk.eaf, walk.TextGrid, walk.txt (Audacity) or walk.json (Label Studio). JSON without labels is ignored.
A folder of moves has label files of sessions, {"recording": "ann.npz", "commands": [[0, 165, "jab_left"], ...]}: the
player did a move from the first frame until before the last one. "moves" names a file of mossar teach with the examples.
Otherwise they are in samples/ann.npz: arrays (n, J, 3), metres, called MOVE_NUMBER, as in jab_left_1. Examples of several
people in samples/ are also recognised with those of the others.
With --preset and --set other settings can be tried; the level is that of each recording's label."""
EXAMPLES = """  mossar evaluate demo:                                the built-in performer, without any data
  mossar evaluate 'demo:?noise=0.02&fps=30' --seeds 5
  mossar evaluate DIR --plot strips.png                a strip per recording: curve, truth, key frames
  mossar evaluate DIR                                  of moves on command: F1, delay and limb, by move
  mossar evaluate DIR --set sig_threshold=0.03
  mossar evaluate DIR1 DIR2 --stretch 0.6,1,2          performers quicker than recorded, as recorded, and half as fast
  mossar evaluate DIR1 DIR2 DIR3 --leave-out           several sets, each also with what serves the others best
"""

SHOWN = "Mossar default, streaming"  # the method whose recordings are listed one by one


Seeds = Annotated[int | None, Option("performances of each kind of demo: (default: 20)", "N", count)]


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[tuple[str, ...], operand("DIR", "folders of labelled recordings, or demo:", "+")]
    leave_out: Annotated[
        bool,
        Section("method and output"),
        Option("with several folders, score each with the best strength of the others"),
    ] = False
    stretch: Annotated[
        tuple[float, ...] | None,
        Option(
            "final key frames of the same recordings stretched in time, as if performers were so many times as slow",
            "X,...",
            factors,
        ),
    ] = None
    strict: Annotated[
        float | None,
        Option("of moves on command, how strict all moves are, 0 to 1 (default: 0.5)", "X", share),
    ] = None
    json: Annotated[str | None, output("everything as one JSON object")] = None
    csv: Annotated[str | None, output("a row for each method and recording")] = None
    picture: Picture = Picture()
    seeds: Seeds = None
    segmentation: LabelledSegmenting = LabelledSegmenting()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    _refuse_what_would_change_nothing(options)
    settings = options.segmentation.settings(*options.sources)
    outputs = Outputs.of(options)
    if options.stretch is not None:
        return _stretched(options, console, outputs, settings)
    if len(options.sources) > 1:
        if options.strict is not None:
            raise UsageError("--strict takes one folder of moves on command")
        return _sets(options, console, outputs, settings)
    if options.leave_out:
        raise UsageError("--leave-out needs several folders: one is left out, the others choose")
    if _is_of_moves(options):
        return _moves(options, console, outputs, settings)
    if options.strict is not None:
        raise UsageError("--strict takes a folder of moves on command")
    takes = load_takes(options.sources[0], options.seeds, console)
    from mossar_tools.evaluation.chance import chance_methods
    from mossar_tools.evaluation.mossar import mossar_methods
    from mossar_tools.evaluation.report import as_json, recording_table, tables
    from mossar_tools.evaluation.trial import groups_of, trial

    groups = groups_of(takes)
    methods = [*mossar_methods(settings), *chance_methods(settings)]
    progress = _progress(console, len(methods) * len(takes))
    rows = {name: trial(own, methods, progress) for name, own in groups.items()}
    report = as_json(groups, rows)
    shown = {name: next(row for row in rows[name] if row.method == SHOWN) for name in groups}
    lists = (("", *recording_table(own, shown[name])) for name, own in groups.items())
    lines = itertools.chain(tables(groups, rows), *lists)
    outputs.write(console, report, _flat(report), lines)
    if outputs.picture is not None:
        from mossar_tools.evaluation.strips import draw_strips

        console.status("drawing ...", now=True)
        left_out = draw_strips(outputs.picture, groups, rows, settings, palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}" + (f" ({left_out} recordings left out)" if left_out else ""))
    return DONE


def _refuse_what_would_change_nothing(options: Options) -> None:
    if "level" in options.segmentation.set:
        raise UsageError("the level is that of each recording's label; --set level=... would change nothing")


def _is_of_moves(options: Options) -> bool:
    """Return whether the folder holds moves; a demo is no folder."""
    from mossar_tools.evaluation.moves_report import is_of_moves

    address = parse_url(options.sources[0])
    return address.scheme == "file" and is_of_moves(Path(address.path))


def _moves(options: Options, console: Console, outputs: Outputs, settings: Settings) -> int:
    """Show the results of moves on command, and of segmented examples."""
    from mossar_tools.evaluation.moves_report import evaluate_moves, moves_json, moves_lines, moves_rows

    if options.picture.plot:
        raise UsageError("--plot takes a folder with true cuts; this one holds moves")
    found = evaluate_moves(
        Path(parse_url(options.sources[0]).path),
        settings,
        console.status,
        strict=options.strict,
    )
    outputs.write(console, moves_json(found), moves_rows(found), moves_lines(found))
    return DONE


def _stretched(options: Options, console: Console, outputs: Outputs, settings: Settings) -> int:
    """Show the scores of final key frames on recordings that are stretched in time."""
    from mossar_tools.evaluation.report import as_json
    from mossar_tools.evaluation.sets import load_sets
    from mossar_tools.evaluation.stretching import score_stretched, stretched_sets, stretching_table
    from mossar_tools.evaluation.trial import groups_of

    refused = {
        "--plot": options.picture.plot,
        "--leave-out": options.leave_out,
        "--strict": options.strict is not None,
    }
    for name in (name for name, given in refused.items() if given):
        raise UsageError(f"--stretch and {name} do not go together; leave one of them out")
    is_demo = parse_url(options.sources[0]).scheme == "demo"
    if is_demo or (len(options.sources) == 1 and _is_of_moves(options)):
        if not is_demo:
            raise UsageError("--stretch takes folders with true cuts; this one holds moves")
        sets = groups_of(load_takes(options.sources[0], options.seeds, console))
    else:
        folders = [Path(source) for source in options.sources]
        sets = load_sets(folders, lambda path: console.status(f"reading {path}"))
    factors = options.stretch or ()
    played = stretched_sets(sets, factors)
    rows = score_stretched(played, settings, console.status)
    report = as_json(played, rows)
    outputs.write(console, report, _flat(report), stretching_table(list(sets), factors, rows))
    return DONE


def _sets(options: Options, console: Console, outputs: Outputs, settings: Settings) -> int:
    """Show several folders beside each other."""
    from mossar_tools.evaluation.report import as_json, tables
    from mossar_tools.evaluation.sets import compare_sets, load_sets

    if options.picture.plot:
        raise UsageError("--plot takes one folder")
    folders = [Path(source) for source in options.sources]
    sets = load_sets(folders, lambda path: console.status(f"reading {path}"))
    rows = compare_sets(sets, settings, console.status, leave_out=options.leave_out)
    report = as_json(sets, rows)
    outputs.write(console, report, _flat(report), tables(sets, rows))
    return DONE


def _progress(console: Console, steps: int) -> Callable[[str], None]:
    """Return a function that shows a progress bar; it must be called before each step."""
    done = itertools.count()
    return lambda text: console.progress(next(done) / steps, text)


def _flat(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each group, method and recording."""
    return [
        {
            "group": group["group"],
            "method": method["method"],
            "choice": method["choice"],
            "recording": recording["name"],
            **{name: value for name, value in recording.items() if name not in {"name", "key_frames_s"}},
        }
        for group in report["groups"]
        for method in group["methods"]
        for recording in method["recordings"]
    ]


def load_takes(source: str, seeds: int | None, console: Console) -> Sequence[Take]:
    """Return the labelled takes of a folder, or of the built-in performer.

    Args:
        source: The folder, or demo: with its options.
        seeds: Performances of each kind of demo:; None for the usual number.
        console: Where progress is shown.

    Raises:
        UsageError: If the source is neither.
        LabelError: If a label file cannot be used.
        FileError: If a recording cannot be read.
    """
    from mossar_tools.evaluation.performer import SEEDS, demo_takes
    from mossar_tools.evaluation.takes import load_folder

    address = parse_url(source)
    if address.scheme == "demo":
        return list(demo_takes(source, seeds or SEEDS))
    if address.scheme != "file":
        raise UsageError(f"{source}: mossar evaluate takes a folder of labelled recordings or demo:")
    return load_folder(Path(address.path), lambda path: console.status(f"reading {path}"))
