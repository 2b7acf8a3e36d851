"""`mossar run`: segment live or recorded streams."""

import argparse

from mossar_tools.console import Console, is_terminal
from mossar_tools.errors import UsageError
from mossar_tools.options import Options, add_page, add_segmenting, add_speed, add_stream, which_source

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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    parser.add_argument(
        "sources",
        metavar="SOURCE",
        nargs="*",
        help="a port, a URL, a recording, or - for JSON lines; several are possible",
    )
    add_speed(parser, "max for recordings, 1 for demo:")
    add_stream(parser)
    parser.add_argument(
        "--explain",
        action="store_true",
        help="with --moves: a line about each movement: the nearest move, and the reason why it was not recognised; with "
        "--follow also about each performance that was given up",
    )
    parser.add_argument("--view", action="store_true", help="also show the dashboard in a browser")
    add_page(parser)
    add_segmenting(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_tools.streaming import stream

    if not options.sources:
        raise UsageError(which_source("run", options))
    if options.explain and not options.moves:
        raise UsageError("--explain needs --moves: it says which move was nearest in each movement")
    if options.view and options.page == "player":
        from mossar_tools.player_page.opening import stream_with_page

        status, summary = stream_with_page(options, console, page_only=False)
    else:
        status, summary = stream(options, console)
    if is_terminal(console.out) and not options.quiet:
        for line in summary:
            console.say(line)
    return status
