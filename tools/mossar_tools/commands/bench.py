"""`mossar bench`: speed, delay and memory on this machine."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec

from mossar_tools.bench.measures import MEASURES, Measures, chosen, measure
from mossar_tools.console import Console
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE
from mossar_tools.options import Messages, Picture, output
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette
from mossar_tools.values import names

if TYPE_CHECKING:
    from mossar_adapters.files.loaded import LoadedRecording
    from mossar_tools.bench.measurement import Measurement

DESCRIPTION = """Measure speed, delay and memory on this machine: the built-in performer at 120 fps with 31 joints, and
recordings if given. Medians of repeated runs beside their targets. If other processes load the machine, processor time is shown
instead of wall time."""
EXAMPLES = """  mossar bench                                  some minutes, more on a busy machine
  mossar bench --only stream,push               the parts: stream push performers memory
  mossar bench DIR --plot speed.png             real recordings: a file, or a labelled folder as for evaluate
  mossar bench --json | jq '.measurements[] | {name, median, unit}'
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command and of `checks.speed`."""

    sources: Annotated[tuple[str, ...], operand("FILE", "recordings, or labelled folders", "*")] = ()
    only: Annotated[
        tuple[str, ...],
        Section("measurement and output"),
        Option("only these parts", "NAME,NAME", names),
    ] = ()
    quick: Annotated[bool, Option("a short test run; the numbers mean little")] = False
    json: Annotated[str | None, output("everything as one JSON object")] = None
    csv: Annotated[str | None, output("a row for each measurement")] = None
    picture: Picture = Picture()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    return measured(options, console, MEASURES)


def measured(options: Options, console: Console, measures: Measures) -> int:
    """Measure, write all outputs, and return the exit status.

    Args:
        options: The user's options.
        console: The terminal.
        measures: The measures by name.
    """
    outputs = Outputs.of(options)
    from mossar_tools.bench.machine import Watch
    from mossar_tools.bench.report import NOTES, as_json, machine_lines, table

    watch = Watch()
    parts = chosen(options.only, measures)
    rows = _rows({name: measures[name] for name in parts}, options, console, shown=not outputs.piped)
    machine = watch.machine()
    if not outputs.piped:
        for line in (*NOTES.splitlines(), *machine_lines(machine)):
            console.line(line)
    outputs.write_json(as_json(machine, rows), console)
    outputs.write_csv(table(rows), console)
    if outputs.picture is not None:
        from mossar_tools.bench.picture import draw

        about = f"{machine.cpu}, {machine.cores} cores"
        draw(outputs.picture, rows, measures, about, palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _rows(measures: Measures, options: Options, console: Console, *, shown: bool) -> "list[Measurement]":
    """Measure part by part; each table appears when its part is measured."""
    from mossar_tools.bench.machine import Watch
    from mossar_tools.bench.report import part_lines
    from mossar_tools.bench.work import prepare

    work = prepare(
        _recordings(options.sources),
        quick=options.quick,
        on_progress=lambda text: console.status(text, now=True),
    )
    rows = []
    for name, part in measures.items():
        work.on_progress(f"{name} ...")
        watch = Watch()
        own = list(measure(part, work))
        rows += own
        if shown:
            for line in (*part_lines(part.title, own, busy=watch.machine().busy), ""):
                console.line(line)
    return rows


def _recordings(sources: Sequence[str]) -> "list[LoadedRecording]":
    """Return the recordings of all files and labelled folders."""
    from mossar_adapters.files.loaded import LoadedRecording
    from mossar_tools.loaded_recording import load_recording

    wholes = []
    for source in sources:
        if Path(source).is_dir():
            from mossar_tools.evaluation.takes import load_folder

            takes = load_folder(Path(source))
            wholes += [LoadedRecording(t.name, t.skeleton, t.fps, t.positions, t.times) for t in takes]
        else:
            wholes.append(load_recording(source))
    return wholes
