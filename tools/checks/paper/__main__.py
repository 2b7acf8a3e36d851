"""The program: `python -m checks.paper DIR|demo: [--json FILE] [--plot FILE]`."""

import sys
from typing import Annotated

import msgspec

from checks.paper.experiments import experiments
from checks.paper.tables import grids_json, paper_tables
from mossar_stream import Settings
from mossar_tools.cli import guarded, run_command
from mossar_tools.commands.evaluate import Seeds, load_takes
from mossar_tools.console import Console
from mossar_tools.declared import Section, operand
from mossar_tools.errors import DONE, UsageError
from mossar_tools.options import LabelledSegmenting, Messages, Picture, output
from mossar_tools.outputs import Outputs
from mossar_tools.palette import palette

DESCRIPTION = """Repeat the paper's experiments on labelled recordings: Tables 2 to 7 and Figures 11 to 14. The conventional
velocity-based method and splitting over smoothing and threshold; Li and Leung's method and Mossar over N and L; random
merging beside them. They start from the paper's settings. Four recordings take some 7 minutes, and 13 on a busy machine."""
EXAMPLES = """  python -m checks.paper demo: --seeds 2
  python -m checks.paper DIR --plot paper.pdf          a labelled folder as for mossar evaluate
  python -m checks.paper DIR --json paper.json
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this program."""

    sources: Annotated[tuple[str, ...], operand("DIR", "a folder of labelled recordings, or demo:", 1)]
    json: Annotated[str | None, Section("output"), output("all numbers as one JSON object")] = None
    picture: Picture = Picture()
    seeds: Seeds = None
    segmentation: LabelledSegmenting = LabelledSegmenting()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the experiments, print their results, and return the exit status."""
    if options.segmentation.preset == "game":
        raise UsageError("the experiments start from the paper's preset; leave --preset out")
    outputs = Outputs.of(options)
    settings = Settings.build("paper", options.segmentation.set)
    takes = load_takes(options.sources[0], options.seeds, console)
    done = experiments(takes, settings, console.status)
    found = {"v": 1, "splitting": grids_json(done.splitting), "remerging": grids_json(done.remerging)}
    outputs.write_json(found, console)
    if not outputs.piped:
        for line in paper_tables(done.splitting, done.remerging, done.chance):
            console.line(line)
    if outputs.picture is not None:
        from checks.paper.surfaces import draw_surfaces

        draw_surfaces(outputs.picture, done.splitting, done.remerging, palette(dark=options.picture.dark))
        console.say(f"drawn: {outputs.picture}")
    return DONE


if __name__ == "__main__":
    own = sys.modules[__name__]
    sys.exit(guarded(lambda terminal: run_command("python -m checks.paper", own, sys.argv[1:], terminal)))
