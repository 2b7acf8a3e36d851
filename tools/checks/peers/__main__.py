"""The program: `python -m checks.peers [DIR ...] [--json FILE] [--csv FILE] [--plot FILE]`."""

import sys
from pathlib import Path
from typing import Annotated

import msgspec

from checks.peers.results import NOTES, compare, result_lines, results_json, usable_peers
from mossar_tools.bench.machine import Watch
from mossar_tools.bench.report import machine_lines
from mossar_tools.cli import guarded, run_command
from mossar_tools.console import Console
from mossar_tools.declared import Option, Section, operand
from mossar_tools.errors import DONE
from mossar_tools.evaluation.performer import demo_takes
from mossar_tools.evaluation.takes import Take, load_folder
from mossar_tools.evaluation.trial import groups_of
from mossar_tools.options import Messages, Picture, output
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette

DEMO_SEEDS = 4  # performances of each kind
REPEATS = 3

DESCRIPTION = """Let mossar-stream, river, stumpy, claspy and ruptures find the cuts of the same labelled recordings, or of the
built-in performer: F1, delay and throughput side by side. The other libraries come with pip install '.[peers]', in an
environment of its own."""
EXAMPLES = """  python -m checks.peers                        the built-in performer
  python -m checks.peers DIR --plot peers.png   labelled folders as for mossar evaluate
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this program."""

    sources: Annotated[tuple[str, ...], operand("DIR", "labelled folders", "*")] = ()
    quick: Annotated[
        bool,
        Section("measurement and output"),
        Option("see that it works; the numbers say little"),
    ] = False
    json: Annotated[str | None, output("everything as one JSON object")] = None
    csv: Annotated[str | None, output("a row for each measurement")] = None
    picture: Picture = Picture()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Compare, put everything out, and return the exit status."""
    outputs = Outputs.of(options)
    watch = Watch()
    peers, missing = usable_peers()
    for note in missing:
        console.say(f"mossar: {note}")
    repeats = 1 if options.quick else REPEATS

    def on_progress(text: str) -> None:
        console.status(text, now=True)

    rows = list(compare(groups_of(_takes(options)), peers, repeats, on_progress))
    machine = watch.machine()
    if not outputs.piped:
        for line in (*result_lines(rows), *NOTES.splitlines(), *machine_lines(machine)):
            console.line(line)
    flat = results_json(rows)
    outputs.write_json({"v": 1, "machine": machine, "busy": machine.busy, "peers": flat}, console)
    outputs.write_csv(flat, console)
    if outputs.picture is not None:
        from checks.peers.picture import draw

        draw(outputs.picture, rows, palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}")
    return DONE


def _takes(options: Options) -> list[Take]:
    """Return labelled takes: those of the folders given, else of the built-in performer."""
    if not options.sources:
        return list(demo_takes(seeds=1 if options.quick else DEMO_SEEDS))
    return [take for source in options.sources for take in load_folder(Path(source))]


if __name__ == "__main__":
    own = sys.modules[__name__]
    sys.exit(guarded(lambda terminal: run_command("python -m checks.peers", own, sys.argv[1:], terminal)))
