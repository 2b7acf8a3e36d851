"""`mossar webcam`: the former name of `mossar view webcam:browser` and of `mossar adapters --get-model`."""

from typing import Final

import msgspec

from mossar_tools.commands.adapters import GetModel, ModelName, get_model
from mossar_tools.commands.run import as_run
from mossar_tools.console import LOGGER, Console
from mossar_tools.options import Body, Messages, PageOptions, Segmenting, Streaming

POINTER: Final = "mossar webcam is now: mossar view webcam:browser; this name stays for one more release"
DESCRIPTION = """Show the page of mossar view webcam:browser, under its former name, which stays for one more release. The browser's camera is the
sensor of the page: choose a camera, see the mirrored picture with the skeleton, count and verdict. Pictures stay in the
browser. --to names the sinks of events, as with mossar run. A camera without a browser: mossar run webcam:"""
EXAMPLES = """  mossar webcam                                         opens the page; key frames in the terminal
  mossar webcam --to osc://127.0.0.1:9000               the same, key frames to a game
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    get_model: GetModel = False
    model: ModelName = None
    page: PageOptions = PageOptions()
    streaming: Streaming = Streaming()
    segmentation: Segmenting = Segmenting()
    body: Body = Body()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.pose.weights import GET, USUAL

    if options.get_model:
        LOGGER.warning("mossar webcam --get-model is now: %s; this name stays for one more release", GET)
        return get_model(options.model, console)
    return _serve(options, options.model or USUAL, console)


def _serve(options: Options, model: str, console: Console) -> int:
    """Run `mossar view webcam:browser`, and report events as before."""
    from mossar_tools.player_page.opening import stream_with_page

    LOGGER.warning("%s", POINTER)
    streamed = as_run(options, view=True, sources=(f"webcam:browser?model={model}",))
    return stream_with_page(streamed, console, page_only=False)[0]
