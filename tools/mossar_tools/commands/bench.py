"""`mossar bench`: speed, delay and memory on this machine."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import msgspec.structs

from mossar_tools.console import Console
from mossar_tools.errors import DONE, UsageError
from mossar_tools.options import Options, add_messages
from mossar_tools.values import names

if TYPE_CHECKING:
    from mossar_tools.bench.machine import Watch
    from mossar_tools.bench.measurement import Measurement
    from mossar_tools.evaluation.takes import Take
    from mossar_tools.whole import Whole

DEMO_SEEDS = 4  # performances of each kind, for the peers

DESCRIPTION = """Measure speed, delay and memory on this machine: the built-in performer at 120 fps with 31 joints, and
recordings if some are given. Repeated runs, medians; targets beside them; and whether neighbours were at work, in which
case processor time is shown where the wall clock says nothing."""
EXAMPLES = """  mossar bench                                  ten minutes
  mossar bench --only splitting,stream,push     a minute; the parts are splitting stream push stages performers
                                                memory start paths hierarchy joints window latency
  mossar bench DIR --plot speed.png             real recordings: a file, or a labelled folder as for evaluate
  mossar bench --json - | jq '.measurements[] | {name, median, unit}'
  mossar bench DIR --peers                      beside river, stumpy, claspy and ruptures
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument("sources", metavar="FILE", nargs="*", help="recordings, or labelled folders")
    group = parser.add_argument_group("what to measure and to put out")
    group.add_argument("--only", metavar="NAME,NAME", type=names, help="these parts only")
    group.add_argument("--peers", action="store_true", help="compare with other libraries instead")
    group.add_argument("--quick", action="store_true", help="see that it works; the numbers say little")
    group.add_argument(
        "--json", metavar="FILE", dest="json_to", help="everything as JSON; - for standard output"
    )
    group.add_argument("--plot", metavar="FILE", help="draw a picture: .png, .svg or .pdf")
    group.add_argument("--dark", action="store_true", help="a picture for dark pages")
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    picture = None
    if options.plot is not None:
        from mossar_tools.figures import check_picture

        picture = check_picture(options.plot)
    from mossar_tools.bench.machine import Watch
    from mossar_tools.bench.measures import chosen
    from mossar_tools.bench.report import NOTES, as_json, machine_lines
    from mossar_tools.streaming import saying_if_cold

    watch = Watch()
    if options.peers:
        return _against_peers(options, console, watch, picture)
    parts = chosen(options.only)
    with saying_if_cold():
        rows = _measured(parts, options, console)
    machine = watch.machine()
    if options.json_to != "-":
        for line in (*NOTES.splitlines(), *machine_lines(machine)):
            console.line(line)
    if options.json_to is not None:
        _write(options.json_to, as_json(machine, rows), console)
    if picture is not None:
        from mossar_tools.bench.picture import draw
        from mossar_tools.palette import DARK, LIGHT

        draw(picture, rows, f"{machine.cpu}, {machine.cores} cores", DARK if options.dark else LIGHT)
        console.say(f"drawn: {picture}")
    return DONE


def _measured(parts: Sequence[str], options: Options, console: Console) -> "list[Measurement]":
    """Measure part by part; tables appear as soon as they are there."""
    from mossar_tools.bench.machine import Watch
    from mossar_tools.bench.measures import measure
    from mossar_tools.bench.report import part_lines
    from mossar_tools.bench.work import prepare

    work = prepare(
        _recordings(options), quick=options.quick, tell=lambda text: console.status(text, now=True)
    )
    rows = []
    for part in parts:
        work.tell(f"{part} ...")
        watch = Watch()
        own = list(measure(part, work))
        rows += own
        if options.json_to != "-":
            for line in (*part_lines(own, busy=watch.machine().busy), ""):
                console.line(line)
    return rows


def _against_peers(options: Options, console: Console, watch: "Watch", picture: Path | None) -> int:
    """Let other libraries and ours find the cuts of labelled recordings."""
    from mossar_tools.bench.peers.standings import (
        NOTES,
        contest,
        standing_lines,
        standings_json,
        usable_peers,
    )
    from mossar_tools.bench.report import machine_lines
    from mossar_tools.evaluation.trial import groups_of
    from mossar_tools.streaming import saying_if_cold

    if options.only:
        raise UsageError("--only chooses among what is measured of ours; --peers compares as a whole")
    peers, missing = usable_peers()
    for note in missing:
        console.say(f"mossar: {note}")
    with saying_if_cold():
        repeats = 1 if options.quick else 3
        tell = console.status
        rows = list(contest(groups_of(_takes(options)), peers, repeats, lambda text: tell(text, now=True)))
    machine = watch.machine()
    if options.json_to != "-":
        for line in (*standing_lines(rows), *NOTES.splitlines(), *machine_lines(machine)):
            console.line(line)
    if options.json_to is not None:
        report = {"v": 1, "machine": machine, "busy": machine.busy, "peers": standings_json(rows)}
        _write(options.json_to, report, console)
    if picture is not None:
        from mossar_tools.bench.peers.picture import draw
        from mossar_tools.palette import DARK, LIGHT

        draw(picture, rows, DARK if options.dark else LIGHT)
        console.say(f"drawn: {picture}")
    return DONE


def _takes(options: Options) -> "list[Take]":
    """Return labelled takes: those of the folders given, else of the built-in performer."""
    from mossar_tools.evaluation.performer import demo_takes
    from mossar_tools.evaluation.takes import load_folder

    if not options.sources:
        takes = demo_takes(seeds=1 if options.quick else DEMO_SEEDS)
        return list(takes)
    found = []
    for source in options.sources:
        found += load_folder(Path(source))
    return found


def _recordings(options: Options) -> "list[Whole]":
    """Return the recordings of all files and labelled folders."""
    from mossar_tools.whole import Whole, read_whole

    wholes = []
    for source in options.sources:
        if Path(source).is_dir():
            from mossar_tools.evaluation.takes import load_folder

            takes = load_folder(Path(source))
            wholes += [Whole(t.name, t.skeleton, t.fps, t.positions, t.times) for t in takes]
        else:
            wholes.append(read_whole(msgspec.structs.replace(options, file=source)))
    return wholes


def _write(target: str, report: dict[str, Any], console: Console) -> None:
    text = msgspec.json.format(msgspec.json.encode(report), indent=1)
    if target == "-":
        console.line(text.decode())
        return
    try:
        Path(target).write_bytes(text + b"\n")
    except OSError as error:
        raise UsageError(f"{target}: cannot be written: {error.strerror or error}") from None
