"""Streaming: the common part of `demo` and `run`, from options to exit status."""

import contextlib
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mossar_adapters.abilities import HasSlots, Previews, SkipsWaiting, offered
from mossar_adapters.address import parse_url
from mossar_adapters.control.listener import ControlListener
from mossar_adapters.files.claim import Claim
from mossar_adapters.files.errors import FileError, UnwritableError
from mossar_adapters.pipeline import Outcome, Pipeline, Snapshot, Upkeep, read_snapshot
from mossar_adapters.pipeline.emission import Emission
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Source
from mossar_stream import FrameError, Moves, Segmenter, Settings, Skeleton
from mossar_tools.console import LOGGER, Console, is_terminal
from mossar_tools.emitting import check_emission, tell_what_tables_leave_out
from mossar_tools.errors import DONE, FAILED, WRONG_USAGE, UsageError
from mossar_tools.explaining import line_of
from mossar_tools.live_view import LiveView
from mossar_tools.moves_file import Follow, moves_to_follow
from mossar_tools.opening import sink_of, source_of
from mossar_tools.options import Streaming
from mossar_tools.signals import stopping
from mossar_tools.uncounted import UncountedMoves

if TYPE_CHECKING:
    from mossar_adapters.control.requests import Control
    from mossar_tools.commands.run import Options
    from mossar_tools.dashboard.live import LiveShow
    from mossar_tools.player_page.server import PlayerServer

# Seconds from the opening of sources to the first look at them; a dashboard takes longer to open.
_LATE: Final = 0.5


def stream(
    options: "Options",
    console: Console,
    *,
    page_only: bool = False,
    server: "PlayerServer | None" = None,
    view_of: type[LiveView] = LiveView,
) -> tuple[int, list[str]]:
    """Run a pipeline by the options.

    Args:
        options: As of `mossar run`.
        console: Receives the words.
        page_only: Whether the dashboard is all there is to see, unless sinks are named.
        server: Of the page for players, which is shown in place of the dashboard; None for the dashboard.
        view_of: The view of a terminal.

    Returns:
        The exit status, and the summary; empty if the reader is gone.
    """
    settings = options.segmentation.settings(*options.sources)
    streaming = options.streaming
    emission = Emission(streaming.emit)
    teaches = page_only or server is not None
    check_emission(streaming, settings, emission, teaches=teaches)
    tell_what_tables_leave_out(streaming, settings)
    moves, follow = moves_to_follow(streaming.moves, streaming.follow, teaches=teaches)
    if streaming.follow and not follow:
        LOGGER.info("%s has nothing to follow yet; Teach on the page takes an example", streaming.moves)
    if moves is not None and options.explain:
        moves.explained = lambda explanation: LOGGER.info("%s", line_of(explanation))
    check_streamable(settings, moves, follow)
    with contextlib.ExitStack() as opened:
        snapshot = _snapshot(streaming.snapshot, opened)
        began = time.monotonic()
        listeners = [ControlListener() for _ in options.sources]
        sources = _opened_sources(options, listeners, opened)
        visible = is_terminal(console.out) and "-" not in streaming.to and not page_only
        view = view_of(console, sources, visible=visible, emission=emission)
        uncounted = UncountedMoves(explains=options.explain) if moves is not None else None
        missing: list[str] = []
        show = _opened_show(options, settings, sources, opened, server) if options.view else None
        pipeline = Pipeline(
            sources,
            []
            if page_only and not streaming.to
            else _opened_sinks(streaming, console, snapshot, opened, missing),
            settings,
            views=[one for one in (view, show, uncounted) if one is not None],
            emit=streaming.emit,
            seconds=streaming.seconds,
            upkeep=Upkeep(
                stats=streaming.stats,
                snapshot=Path(streaming.snapshot) if streaming.snapshot else None,
                period=streaming.snapshot_every,
            ),
            moves=moves,
            follow=follow,
            resume=snapshot,
            run_id=streaming.run_id,
            tick=lambda: _tick(pipeline, view, show),
        )
        pipeline.outcome.dead_sinks += missing
        if time.monotonic() - began > _LATE:
            _skip_what_waits(sources)
        with (
            _controls(options, pipeline, listeners),
            _metrics(streaming.metrics, pipeline),
            stopping(pipeline.stop) as stop,
        ):
            outcome = pipeline.run()
    if outcome.abandoned:
        return DONE, []
    return stop.status or _status(outcome), view.summary()


def _skip_what_waits(sources: Sequence[Source]) -> None:
    """Discard frames that live sources received before now."""
    for source in sources:
        if (live := offered(source, SkipsWaiting)) is not None:
            live.skip_waiting()


def _tick(pipeline: Pipeline, view: LiveView, show: "LiveShow | None") -> None:
    view.tick(pipeline)
    if show is not None:
        show.tick(pipeline)


def _opened_show(
    options: "Options",
    settings: Settings,
    sources: Sequence[Source],
    opened: contextlib.ExitStack,
    server: "PlayerServer | None",
) -> "LiveShow":
    """Show the stream, on the page for players if there is a server of it, else on the dashboard."""
    from mossar_tools.dashboard.live import LiveShow
    from mossar_tools.dashboard.visitors import HERE

    has_people = any(offered(source, HasSlots) is not None for source in sources)
    previews = [cam.preview for source in sources if (cam := offered(source, Previews)) is not None]
    if previews and options.page.host != HERE:
        raise UsageError("?picture=yes shows pictures on this computer only; leave --host out")
    moves = Path(options.streaming.moves) if options.streaming.moves else None
    if server is not None:
        from mossar_tools.player_page.opening import open_player_page, pictures_of, wanted_names

        pictures = pictures_of(sources, options)
        previews = pictures if options.page.host == HERE else []
        show = LiveShow(
            settings, moves, has_people=has_people, previews=previews, follow=wanted_names(options)
        )
        open_player_page(server, show, options, pictures, opened)
        return show
    from mossar_tools.dashboard.page import Page

    show = LiveShow(
        settings, moves, has_people=has_people, previews=previews, follow=options.streaming.follow
    )
    page = Page(show, options.page.port, dark=options.page.dark, host=options.page.host)
    opened.callback(page.close)
    page.start(open_browser=not options.page.no_browser)
    return show


def check_streamable(settings: Settings, moves: Moves | None = None, follow: Follow = ()) -> None:
    """Check, before the first performer comes, that a stream can have these settings and moves.

    Raises:
        ValueError: If it cannot have the settings.
        MossarError: If a move cannot be followed.
    """
    anybody = Skeleton(("a", "b"), (-1, 0)) if moves is None else moves.skeleton
    Segmenter(anybody, settings.replace(limbs=False, steps=False), moves=moves, follow=follow)


def _snapshot(path: str | None, opened: contextlib.ExitStack) -> Snapshot | None:
    """Return the snapshot of an interrupted run, if there is one; the file is this run's until `opened` closes."""
    if path is None:
        return None
    opened.callback(Claim(path).release)
    found = read_snapshot(Path(path))
    if found is None or found.complete:
        return None
    LOGGER.info("%s: going on where the last run was cut short", path)
    return found


def _opened_sources(
    options: "Options", listeners: list[ControlListener], opened: contextlib.ExitStack
) -> list[Source]:
    if options.sources.count("-") > 1:
        raise UsageError("standard input can be read once only")
    sources = []
    reading = options.body.reading(again=options.streaming.force)
    for url, listener in zip(options.sources, listeners, strict=True):
        sources.append(source_of(url, reading, options.people, options.speed, listener))
        opened.callback(sources[-1].close)
    return sources


def _opened_sinks(
    streaming: Streaming,
    console: Console,
    snapshot: Snapshot | None,
    opened: contextlib.ExitStack,
    missing: list[str],
) -> list[Sink | FrameSink]:
    """Open the sinks; those that cannot be written, if there are others, become `missing`."""
    wanted: Sequence[str] = streaming.to or (() if is_terminal(console.out) else ("-",))
    sinks: list[Sink | FrameSink] = []
    for place, url in enumerate(wanted, 1):
        try:
            sinks.append(sink_of(url, snapshot.sinks if snapshot else {}, force=streaming.force))
        except UnwritableError as error:
            if not sinks and place == len(wanted):
                raise
            LOGGER.error("%s; the stream continues without it", error)
            missing.append(url)
            continue
        opened.callback(sinks[-1].close)
    return sinks


@contextlib.contextmanager
def _controls(options: "Options", pipeline: Pipeline, listeners: list[ControlListener]) -> Iterator[None]:
    """Open the receiver of requests while the block runs."""
    if not options.streaming.control:
        yield
        return
    from mossar_adapters.control.requests import Control
    from mossar_adapters.control.zeromq import ZmqControl
    from mossar_adapters.zeromq.endpoint import SCHEMES, binds

    control = Control(pipeline)
    with contextlib.ExitStack() as opened:
        for url in options.streaming.control:
            if url == "osc":
                _let_osc_control(options, listeners, control)
            elif (address := parse_url(url)).scheme in SCHEMES and binds(address):
                served = ZmqControl(address, control.answer)
                opened.callback(served.close)
                LOGGER.info("control: requests are answered at %s", served.endpoint)
            else:
                raise UsageError(f"--control {url}: use zmq+bind://127.0.0.1:5560, or osc with an OSC source")
        yield


@contextlib.contextmanager
def _metrics(place: tuple[str, int] | None, pipeline: Pipeline) -> Iterator[None]:
    """Serve counters while the block runs, if wanted."""
    if place is None:
        yield
        return
    from mossar_adapters.metrics import Metrics

    host, port = place
    with contextlib.closing(Metrics(pipeline, port, host)) as served:
        LOGGER.info("metrics: %s", served.url)
        yield


def _let_osc_control(options: "Options", listeners: list[ControlListener], control: "Control") -> None:
    osc = [
        listener
        for listener, url in zip(listeners, options.sources, strict=True)
        if parse_url(url).scheme == "osc"
    ]
    if not osc:
        raise UsageError("--control osc needs an OSC source, as osc://0.0.0.0:39539")
    for listener in osc:
        listener.pass_on_to(control.apply)


def _status(outcome: Outcome) -> int:
    if outcome.errors:
        return WRONG_USAGE if isinstance(outcome.errors[0], FileError | FrameError) else FAILED
    if outcome.none_followed:
        return WRONG_USAGE
    return FAILED if outcome.dead_sinks else DONE
