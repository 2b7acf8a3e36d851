"""`mossar view`: the page for players and clients, and the dashboard."""

import time
from typing import Annotated

import msgspec

from mossar_adapters.address import parse_url
from mossar_tools.commands.run import as_run
from mossar_tools.console import Console
from mossar_tools.declared import operand
from mossar_tools.errors import UsageError
from mossar_tools.options import Body, Messages, PageOptions, People, Segmenting, Speed, Streaming

DESCRIPTION = """Show a camera, or a sender with --follow, --moves or --repetitions, on a page for players and clients: a large
picture, one count, one verdict, and the dashboard one click away. Else show the dashboard in a browser: the motion, the velocity curve with its key frames, the segments; move the
level to see which key frames it keeps. A recording is segmented as a whole and played: press on the curve or on the whole take
below it to jump, on a key frame or its pose to stop there. Key frames are exported as CSV, the whole take as PNG.
Other sources are shown live, and the last seconds are exported; so are recordings with --people, or with an option of a running stream such as --to or --follow."""
COMMON = (
    "--help",
    "--speed",
    "--to",
    "--moves",
    "--follow",
    "--repetitions",
    "--limbs",
    "--level",
    "--set",
    "--people",
    "--host",
    "--port",
    "--no-browser",
    "--dark",
)
EXAMPLES = """  mossar view demo:                            the built-in performer
  mossar view osc://0.0.0.0:39539              a VMC or Kinect program on another computer
  mossar view walk.bvh --speed 0.5             a recording at half its speed; + and - set the number of key frames
  mossar view webcam: --moves moves.json --follow squat   show a squat once (Teach); each further one is counted and judged
  mossar view webcam: --page dashboard         the curve and the sliders of a camera
  mossar view zmq://127.0.0.1:5556 --to osc://127.0.0.1:9000
"""


class Options(msgspec.Struct, frozen=True):
    """The options of this command."""

    sources: Annotated[
        tuple[str, ...], operand("SOURCE", "a URL, a recording, or -; several are possible", "*")
    ] = ()
    page: PageOptions = PageOptions()
    speed: Speed = None
    streaming: Streaming = Streaming()
    segmentation: Segmenting = Segmenting()
    body: Body = Body()
    people: People = People()
    messages: Messages = Messages()


def run(options: Options, console: Console) -> int:
    """Run the command and return the exit status."""
    if not options.sources:
        from mossar_tools.opening import which_source

        raise UsageError(which_source("view", options.page))
    if (
        len(options.sources) == 1
        and parse_url(options.sources[0]).scheme == "file"
        and options.people.people is None
        and options.streaming == Streaming(force=options.streaming.force)
        and options.page.page != "player"
    ):
        return _play(options, console)
    from mossar_tools.player_page.opening import stream_with_page, wants_player_page
    from mossar_tools.streaming import stream

    streamed = as_run(options, view=True, speed=options.speed or _speed(options))
    if wants_player_page(streamed):
        return stream_with_page(streamed, console, page_only=True)[0]
    return stream(streamed, console, page_only=True)[0]


def _speed(options: Options) -> float | None:
    """Return the default speed: that of the wall clock for recordings and demos, None for live streams."""
    schemes = {parse_url(url).scheme for url in options.sources}
    return 1.0 if schemes <= {"file", "demo"} else None


def _play(options: Options, console: Console) -> int:
    """Show a whole recording until the user ends it."""
    speed = options.speed or 1.0
    if speed == "max":
        raise UsageError("--speed max leaves nothing to see; give a number")
    from mossar_adapters.extras import needed
    from mossar_tools.dashboard.page import Page
    from mossar_tools.dashboard.recorded import RecordedShow, read_parts
    from mossar_tools.signals import stopping

    needed("viser", "view", "the dashboard")
    file, shown = options.sources[0], options.page
    settings = options.segmentation.settings(file, range="file")
    parts = read_parts(file, options.body.reading(again=options.streaming.force))
    console.status("segmenting ...", now=True)
    show = RecordedShow(parts, settings, speed)
    console.clear()
    page = Page(show, shown.port, dark=shown.dark, host=shown.host)
    ended: list[bool] = []
    with stopping(lambda: ended.append(True)) as stop:
        page.start(open_browser=not shown.no_browser)
        while not ended:
            time.sleep(0.1)
        page.close()
    return stop.status
