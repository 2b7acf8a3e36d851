"""Opening: when the page for players is shown, its sensor, and the dashboard behind it."""

import contextlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import msgspec

from mossar_adapters.abilities import KeepsPictures, Previews, offered
from mossar_adapters.address import Address, parse_url
from mossar_adapters.extras import installed
from mossar_adapters.pose.settings import DEFAULTS
from mossar_adapters.pose.source import BROWSER, wanted
from mossar_adapters.source import Source
from mossar_stream import MossarError
from mossar_tools.console import LOGGER, Console
from mossar_tools.dashboard.live import LiveShow
from mossar_tools.errors import UsageError
from mossar_tools.moves_file import EVERY
from mossar_tools.options import PageOptions
from mossar_tools.player_page.eye import Eye
from mossar_tools.player_page.page import PlayerPage, Preview
from mossar_tools.player_page.server import PlayerServer

if TYPE_CHECKING:
    from mossar_tools.commands.run import Options
    from mossar_tools.dashboard.page import Page

CAMERA: Final = "webcam"
_STUDIED: Final = {"file", "demo"}  # schemes that the dashboard shows unless --page player asks for this page


def wants_player_page(options: "Options") -> bool:
    """Return whether a command shows the page for players: a camera, or a sender of which something is counted."""
    if options.page.page is not None:
        return options.page.page == "player"
    schemes = {parse_url(url).scheme for url in options.sources}
    if CAMERA in schemes:
        return True
    return _counts(options) and not schemes & _STUDIED


def _counts(options: "Options") -> bool:
    return bool(options.streaming.follow or options.streaming.moves or options.segmentation.repetitions)


def wanted_names(options: "Options") -> Sequence[str]:
    """Return the moves to follow once they are taught: all of them, where the user names neither a file nor moves."""
    return options.streaming.follow if _counts(options) else (EVERY,)


def stream_with_page(options: "Options", console: Console, *, page_only: bool) -> tuple[int, list[str]]:
    """Stream with the page for players until the user has seen enough; see `stream`."""
    from mossar_tools.streaming import stream

    eye, page = _eye_of(options), options.page
    cameras = [url for url in options.sources if parse_url(url).scheme == CAMERA]
    with contextlib.closing(
        PlayerServer(page.port, page.host, eye=eye, dark=page.dark, mirrored=bool(cameras))
    ) as server:
        if eye is not None:
            chosen = {**DEFAULTS, **options.segmentation.set}
            segmentation = msgspec.structs.replace(options.segmentation, set=chosen)
            sources = (eye.source(server.port),)
            options = msgspec.structs.replace(options, sources=sources, segmentation=segmentation)
        return stream(options, console, page_only=page_only, server=server)


def pictures_of(sources: Sequence[Source], options: "Options") -> list[Preview]:
    """Have the cameras among sources keep their latest pictures, unless `?picture=no`, and return functions that return them."""
    for source, url in zip(sources, options.sources, strict=True):
        keeper = offered(source, KeepsPictures)
        if keeper is not None and parse_url(url).options.get("picture") != "no":
            keeper.keep_pictures()
    return [camera.preview for source in sources if (camera := offered(source, Previews)) is not None]


def open_player_page(
    server: PlayerServer,
    show: LiveShow,
    options: "Options",
    pictures: Sequence[Preview],
    opened: contextlib.ExitStack,
) -> None:
    """Show a live show on the page, with the dashboard one click away, until `opened` closes.

    Args:
        server: Of the page.
        show: The show to draw.
        options: As of `mossar run`.
        pictures: Return the latest picture of each camera of this computer.
        opened: Closes the page and the dashboard.
    """
    models = [wanted(address)[1] for url in options.sources if (address := parse_url(url)).scheme == CAMERA]
    page = PlayerPage(
        server,
        show,
        preview=next(iter(pictures), None),
        model=next(iter(models), ""),
        open_dashboard=_dashboard_of(server, show, options.page, opened) if installed("viser") else None,
    )
    opened.callback(page.close)
    page.start(open_browser=not options.page.no_browser)


def _dashboard_of(
    server: PlayerServer, show: LiveShow, options: PageOptions, opened: contextlib.ExitStack
) -> Callable[[], int]:
    """Return a function that opens the dashboard at the first request, and returns its port."""
    pages: list[Page] = []

    def port() -> int:
        if not pages:
            from mossar_tools.dashboard.page import Page

            wanted = server.port + 1 if options.port else 0
            page = Page(show, wanted, dark=options.dark, host=options.host, visitors=server.visitors)
            opened.callback(page.close)
            page.start(open_browser=False)
            pages.append(page)
        return pages[0].port

    return port


def _eye_of(options: "Options") -> Eye | None:
    """Return the browser's camera, if it is the sensor: by the URL, or because this computer has no other for programs."""
    addresses = [parse_url(url) for url in options.sources]
    asked = [address for address in addresses if address.scheme == CAMERA and address.path == BROWSER]
    if not asked:
        asked = [address for address in addresses if address.scheme == CAMERA and _is_missing(address)]
    if not asked:
        return None
    if len(addresses) > 1:
        raise UsageError(f"{asked[0].url}: the browser's camera is the only source of its page")
    model = wanted(msgspec.structs.replace(asked[0], path=""))[1]
    return Eye(model)


def _is_missing(address: Address) -> bool:
    """Return whether a camera that is not named cannot be used by this program, though the browser may have one."""
    if address.path or address.options.get("name"):
        return False
    if not (installed("cv2") and installed("ai_edge_litert")):
        return True
    from mossar_adapters.pose.camera import check_camera

    camera = wanted(address)[0]
    try:
        check_camera(camera)
    except MossarError as error:
        LOGGER.info("%s; the page uses the camera of the browser", error)
        return True
    return False
