"""`mossar demo`: the built-in performer through the whole pipeline."""

import argparse

import msgspec

from mossar_tools.console import Console, is_terminal
from mossar_tools.options import Options, add_messages, add_settings, add_speed, add_stream
from mossar_tools.values import share, whole

SECONDS = 30.0  # of motion, unless the user says otherwise

INTRODUCTION = (
    "A built-in performer plays a script: it rests, walks, turns, punches, kicks, jumps, squats and waves. mossar sees the joints "
    "only, not the script. It reports at once whether the performer is moving or resting. A key frame is where one movement ends and the "
    "next begins. It is decided 1 or 2 seconds later, from what follows. ✓ marks a key frame where the script changes the move, "
    "with the names of the script; · marks one within a move, as between two punches."
)
DESCRIPTION = """Show a built-in performer that rests, walks, punches, kicks and jumps. The terminal shows when it moves and rests, and each
key frame once it is decided, with a mark at true changes of move."""
COMMON = (
    "--help",
    "--speed",
    "--seconds",
    "--seed",
    "--noise",
    "--performers",
    "--level",
    "--set",
    "--limbs",
    "--repetitions",
    "--to",
    "--quiet",
)
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
    from mossar_tools.story import Story
    from mossar_tools.streaming import stream

    seconds = options.seconds or SECONDS
    url = f"demo:?seed={options.seed}&noise={options.noise:g}&performers={options.performers}&seconds={seconds:g}"
    options = msgspec.structs.replace(options, sources=(url,), seconds=None)
    if is_terminal(console.out) and "-" not in options.to and not options.quiet:
        for line in console.fold(INTRODUCTION):
            console.line(line)
    status, summary = stream(options, console, view_of=Story)
    for line in () if options.quiet else summary:
        console.say(line)
    return status
