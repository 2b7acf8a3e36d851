"""`mossar run`: segment live or recorded streams."""

from typing import Annotated, Any

import msgspec

from mossar_tools.console import Console, is_terminal
from mossar_tools.declared import Option, operand
from mossar_tools.errors import UsageError
from mossar_tools.options import Body, Messages, PageOptions, People, Segmenting, SpeedOfReading, Streaming

DESCRIPTION = (
    "Segment live or recorded streams. In a terminal key frames are shown; in a pipe they are JSON lines."
)
COMMON = (
    "--help",
    "--to",
    "--emit",
    "--moves",
    "--follow",
    "--repetitions",
    "--limbs",
    "--steps",
    "--level",
    "--set",
    "--people",
    "--seconds",
    "--view",
    "--quiet",
)
EXAMPLES = """  mossar run 39539                                 a VMC or Kinect program, on this computer or another
  mossar run osc://127.0.0.1:7110 --to osc://127.0.0.1:9000   key frames to a game
  mossar run zmq://127.0.0.1:5556 --to ws://127.0.0.1:8765 --level cluster
  mossar run walk.bvh --to events.jsonl --stats 5
  mossar run take.bvh --moves moves.json --explain --emit move    why was a move not recognised?
  python poses.py | mossar run - | jq 'select(.status == "final")'
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[
        tuple[str, ...],
        operand("SOURCE", "a port, a URL, a recording, or - for JSON lines; several are possible", "*"),
    ] = ()
    speed: SpeedOfReading = None
    streaming: Streaming = Streaming()
    explain: Annotated[
        bool,
        Option(
            "with --moves: a line about each movement: the nearest move, and the reason why it was not recognised; with "
            "--follow also about each performance that was given up"
        ),
    ] = False
    view: Annotated[bool, Option("also show the dashboard in a browser")] = False
    page: PageOptions = PageOptions()
    segmentation: Segmenting = Segmenting()
    body: Body = Body()
    people: People = People()
    messages: Messages = Messages()


def as_run(options: msgspec.Struct, **changes: Any) -> Options:
    """Return the options of another command as options of this one, with defaults for those that the other lacks.

    Args:
        options: The other command's options.
        changes: Fields that override the user's.
    """
    return msgspec.structs.replace(msgspec.convert(options, Options, from_attributes=True), **changes)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_tools.streaming import stream

    if not options.sources:
        from mossar_tools.opening import which_source

        raise UsageError(which_source("run", options.page))
    if options.explain and not options.streaming.moves:
        raise UsageError("--explain needs --moves: it says which move was nearest in each movement")
    if options.view and options.page.page == "player":
        from mossar_tools.player_page.opening import stream_with_page

        status, summary = stream_with_page(options, console, page_only=False)
    else:
        status, summary = stream(options, console)
    if is_terminal(console.out) and not options.messages.quiet:
        for line in summary:
            console.say(line)
    return status
