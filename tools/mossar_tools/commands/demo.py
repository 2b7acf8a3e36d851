"""`mossar demo`: the built-in performer through the whole pipeline."""

import argparse

import msgspec

from mossar_tools.console import Console
from mossar_tools.options import Options, add_messages, add_settings, add_speed, add_stream
from mossar_tools.values import share, whole

SECONDS = 30.0  # of motion, unless the user says otherwise

DESCRIPTION = "A built-in performer rests, walks, punches, kicks, jumps; its key frames appear live beside its true cuts."
EXAMPLES = """  mossar demo                            half a minute at real speed
  mossar demo --speed max --seconds 120  two minutes of motion in a moment
  mossar demo --noise 0.01 --performers 2 --seed 7
  mossar demo | head -3                  in a pipe: JSON lines
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    group = parser.add_argument_group("the performance")
    add_speed(parser, "1")
    group.add_argument("--seed", metavar="N", type=whole, help="number of the performance")
    group.add_argument("--noise", metavar="M", type=share, help="sensor noise in metres (default: 0)")
    group.add_argument("--performers", metavar="N", type=whole, help="number of performers (default: 1)")
    add_stream(parser)
    add_settings(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_tools.streaming import stream

    seconds = options.seconds or SECONDS
    url = f"demo:?seed={options.seed}&noise={options.noise:g}&performers={options.performers}&seconds={seconds:g}"
    status, summary = stream(msgspec.structs.replace(options, sources=(url,), seconds=None), console)
    for line in summary:
        console.say(line)
    return status
