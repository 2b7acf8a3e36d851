"""`mossar demo`: the built-in performer through the whole pipeline."""

from typing import Annotated

import msgspec

from mossar_tools.commands.run import as_run
from mossar_tools.console import Console, is_terminal
from mossar_tools.declared import Option, Section
from mossar_tools.options import Messages, Segmenting, Speed, Streaming
from mossar_tools.values import count, share, whole

SECONDS = 30.0  # of motion by default

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


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    speed: Speed = None
    seed: Annotated[int, Section("the performance"), Option("number of the performance", "N", whole)] = 1
    noise: Annotated[float, Option("sensor noise in metres (default: 0)", "M", share)] = 0.0
    performers: Annotated[int, Option("number of performers (default: 1)", "N", count)] = 1
    streaming: Streaming = Streaming()
    segmentation: Segmenting = Segmenting()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_tools.story import Story
    from mossar_tools.streaming import stream

    seconds = options.streaming.seconds or SECONDS
    url = f"demo:?seed={options.seed}&noise={options.noise:g}&performers={options.performers}&seconds={seconds:g}"
    streaming = msgspec.structs.replace(options.streaming, seconds=None)
    if is_terminal(console.out) and "-" not in streaming.to and not options.messages.quiet:
        for line in console.fold(INTRODUCTION):
            console.line(line)
    streamed = as_run(options, sources=(url,), streaming=streaming)
    status, summary = stream(streamed, console, view_of=Story)
    for line in () if options.messages.quiet else summary:
        console.say(line)
    return status
