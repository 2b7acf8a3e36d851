"""`mossar webcam`: the former name of `mossar view webcam:browser` and of `mossar adapters --get-model`."""

import argparse
from typing import Final

import msgspec

from mossar_tools.commands.adapters import add_get_model, get_model
from mossar_tools.console import LOGGER, Console
from mossar_tools.options import Options, add_body, add_messages, add_page, add_settings, add_stream

POINTER: Final = "mossar webcam is now: mossar view webcam:browser; this name stays for one more release"
DESCRIPTION = """Show the page of mossar view webcam:browser, under its former name, which stays for one more release. The browser's camera is the
sensor of the page: choose a camera, see the mirrored picture with the skeleton, count and verdict. Pictures stay in the
browser. --to names the sinks of events, as with mossar run. A camera without a browser: mossar run webcam:"""
EXAMPLES = """  mossar webcam                                         opens the page; key frames in the terminal
  mossar webcam --to osc://127.0.0.1:9000               the same, key frames to a game
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    add_get_model(parser)
    add_page(parser)
    add_stream(parser)
    add_settings(parser)
    add_body(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.pose.weights import GET, USUAL

    if options.get_model:
        LOGGER.warning("mossar webcam --get-model is now: %s; this name stays for one more release", GET)
        return get_model(options, console)
    return _serve(options, options.model or USUAL, console)


def _serve(options: Options, model: str, console: Console) -> int:
    """Do what `mossar view webcam:browser` does, and report events as before."""
    from mossar_tools.player_page.opening import stream_with_page

    LOGGER.warning("%s", POINTER)
    options = msgspec.structs.replace(options, view=True, sources=(f"webcam:browser?model={model}",))
    return stream_with_page(options, console, page_only=False)[0]
