"""The program: `python -m checks.speed [DIR] [--only splitting,paths] [--json FILE] [--plot FILE]`."""

import sys
from typing import Final

import msgspec.structs

from mossar_tools.bench.measures import MEASURES, Measure
from mossar_tools.cli import guarded, run_command
from mossar_tools.commands import bench
from mossar_tools.console import Console

OWN: Final[dict[str, Measure]] = {
    "moves": Measure("moves: what recognising them adds to a push", "checks.speed.moves:measure"),
    "limbs": Measure(
        "limbs: what key frames of limbs add to a push, their events included", "checks.speed.limbs:measure"
    ),
    "repetitions": Measure(
        "repetitions: what counting them adds to a push", "checks.speed.repetitions:measure"
    ),
    "activity": Measure("activity: what it costs a frame, and its bytes", "checks.speed.activity:measure"),
    "forms": Measure("one frame in other forms of arrays", "checks.speed.forms:measure"),
    "start": Measure("start, in processes of their own", "checks.speed.start:measure"),
    "splitting": Measure(
        "splitting alone: joints, velocity, range, envelope, Algorithms 1 and 2",
        "checks.speed.splitting:measure",
    ),
    "stages": Measure("stages: where the time goes", "checks.speed.stages:measure"),
    "paths": Measure(
        "path kernel: one pair of neighbouring segments, medians over pairs", "checks.speed.paths:measure"
    ),
    "hierarchy": Measure(
        "whole Algorithm 3, positions to strengths, paper's kernel and settings",
        "checks.speed.hierarchy:measure",
    ),
    "joints": Measure("joints: end to end in chunks of 1000", "checks.speed.sizes:measure_joints"),
    "window": Measure("window: end to end in chunks of 1000", "checks.speed.sizes:measure_window"),
    "latency": Measure(
        "latency: from sending a frame to receiving its event, 60 frames/s", "checks.speed.latency:measure"
    ),
}
ALL: Final[dict[str, Measure]] = {**MEASURES, **OWN}

DESCRIPTION = """Measure what developers need beside `mossar bench`: what moves, limbs, repetitions and the activity add to a
frame, other forms of frames, the start, splitting alone, the stages, the path kernel, the hierarchy, the cost of joints and
of the window, and the delay from a frame sent to its event received."""
EXAMPLES = """  python -m checks.speed                            a quarter of an hour
  python -m checks.speed DIR --only hierarchy       real recordings; the parts of mossar bench can be named, too
  python -m checks.speed --only paths --json -
"""
Options = bench.Options


def run(options: bench.Options, console: Console) -> int:
    """Run the command and return the exit status."""
    names = options.only or tuple(OWN)
    return bench.measured(msgspec.structs.replace(options, only=names), console, ALL)


if __name__ == "__main__":
    own = sys.modules[__name__]
    sys.exit(guarded(lambda terminal: run_command("python -m checks.speed", own, sys.argv[1:], terminal)))
