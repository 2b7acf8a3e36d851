"""Sources and sinks by URL: one table of schemes.

A new scheme is one module and one row here. Modules of extras are imported when a URL asks for them.
"""

import difflib
from collections.abc import Callable
from importlib import import_module
from pathlib import PurePath
from typing import Any, Literal

import msgspec

from mossar_adapters.address import Address, parse_url
from mossar_adapters.extras import installed
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Listener
from mossar_adapters.people import REMEMBERED, People, PeopleSource
from mossar_adapters.receiving.checked import BodySource, CheckedSource
from mossar_adapters.receiving.selection import SelectedSource
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Source
from mossar_stream import SettingsError

Speed = float | Literal["max"]
# Schemes whose senders choose joints and units; cameras and the built-in performer are our own.
_DESCRIBED_BY_SENDERS = frozenset(
    ["-", "osc", "osc.udp", "zmq", "zmq+bind", "ipc", "ipc+bind", "zmq+ipc", "zmq+bind+ipc", "ws+bind", "lsl"]
)


class OpenOptions(msgspec.Struct, frozen=True):
    """Options of the program beyond the URL.

    Args:
        options: How to read; the URL's own options are merged in.
        speed: Pace of recordings and of the built-in performer.
        listener: Receives control messages (OSC).
        force: Whether to replace a recording that is there.
        loop: Whether to play a recording again and again.
        position: Byte at which to go on with a file.
        people: For whom slots are kept, None without slots; see `open_source`.
    """

    options: ReadOptions = ReadOptions()
    speed: Speed = "max"
    listener: Listener | None = None
    force: bool = False
    loop: bool = False
    position: int | None = None
    people: People | None = None


class Scheme(msgspec.Struct, frozen=True):
    """One row of the table.

    Args:
        names: The schemes, before the colon.
        form: How such a URL looks, for the user.
        description: One line for `mossar adapters`.
        source: Opens a source, or None.
        sink: Opens a sink of events, or None.
        frame_sink: Opens a sink of frames, or None.
        extra: Extra of the distribution that brings the library, None if none is needed.
        library: Module whose absence means that the extra is missing.
    """

    names: tuple[str, ...]
    form: str
    description: str
    source: Callable[[Address, OpenOptions], Source] | None = None
    sink: Callable[[Address, OpenOptions], Sink] | None = None
    frame_sink: Callable[[Address, OpenOptions], FrameSink] | None = None
    extra: str | None = None
    library: str | None = None

    def available(self) -> bool:
        """Return whether its extra is installed."""
        return self.library is None or installed(self.library)


def open_source(
    url: str,
    *,
    options: ReadOptions | None = None,
    speed: Speed = "max",
    listener: Listener | None = None,
    loop: bool = False,
    people: People | None = None,
    remember: float = REMEMBERED,
) -> Source:
    """Open a source of frames.

    Args:
        url: See the table; a path is a recording, `-` standard input.
        options: The user's options for it; options in the URL take precedence.
        speed: Pace of recordings and of `demo:`; 1 is real time.
        listener: Receives control messages (OSC).
        loop: Whether to play a recording again and again.
        people: Give performers slots instead of the sender's ids: their number, `"nearest"` or `"first"`.
        remember: Time for which an absent person keeps its slot, s.

    Raises:
        MossarError: If it cannot be opened; one line has the reason and the remedy.
    """
    address, opened = _opened(url, "source")
    given = _merged(options or ReadOptions(), address)
    # With slots, --performer is one of them, and not an id of the sender.
    inner = given if people is None else msgspec.structs.replace(given, performer=None)
    wanted = OpenOptions(inner, speed, listener, loop=loop, people=people)
    source: Source = opened(address, wanted)
    if address.scheme in _DESCRIBED_BY_SENDERS:
        source = CheckedSource(source, inner)
    picky = inner.joints or inner.root or inner.performer
    source = SelectedSource(source, inner) if picky and address.scheme != "file" else source
    if people is None:
        return source
    source = PeopleSource(BodySource(source), people, remember)
    return SelectedSource(source, ReadOptions(performer=given.performer)) if given.performer else source


def open_sink(url: str, *, force: bool = False, position: int | None = None) -> Sink:
    """Open a sink of events.

    Args:
        url: See the table; a path ends in `.jsonl` (events) or `.csv` (segments), `-` is standard output.
        force: Whether to replace a file that is there.
        position: Byte at which to go on with a file, instead of replacing it.

    Raises:
        MossarError: If it cannot be opened; one line has the reason and the remedy.
    """
    address, opened = _opened(url, "sink")
    sink: Sink = opened(address, OpenOptions(force=force, position=position))
    return sink


def open_frame_sink(url: str, *, force: bool = False, position: int | None = None) -> FrameSink:
    """Open a sink of frames, for replays and recordings.

    Args:
        url: See the table; a path ends in `.msk` or `.jsonl`, `-` is standard output.
        force: Whether to replace a file that is there.
        position: Byte at which to go on with a `.msk` recording, instead of beginning one.

    Returns:
        The sink. With `?profile=vmc` it also has `announce_motion` and `send_motion` for rotations.

    Raises:
        MossarError: If it cannot be opened; one line has the reason and the remedy.
    """
    address, opened = _opened(url, "frame_sink")
    sink: FrameSink = opened(address, OpenOptions(force=force, position=position))
    return sink


# Likely mistakes for schemes.
_LIKE = {
    "udp": ("osc",),
    "tcp": ("zmq",),
    "http": ("ws+bind", "ws"),
    "https": ("ws+bind", "ws"),
    "camera": ("webcam",),
}
# The option or command for a misplaced scheme.
_INSTEAD = {
    ("ws", "source"): "; ws+bind:// listens for senders",
    ("ws", "frame_sink"): "; osc:// and zmq+bind:// do",
}
_CANNOT = {"source": "cannot be read from", "sink": "takes no events", "frame_sink": "takes no frames"}


def _opened(url: str, use: str) -> tuple[Address, Callable[[Address, OpenOptions], Any]]:
    """Return the address, and the function that opens it for a use."""
    address = parse_url(url)
    for scheme in SCHEMES:
        if address.scheme in scheme.names:
            opened = getattr(scheme, use)
            if opened is None:
                hint = _INSTEAD.get((address.scheme, use), "")
                raise address.error(f"{address.scheme}: {_CANNOT[use]}{hint}")
            return address, opened
    known = ", ".join(
        f"{s.names[0]}:" for s in SCHEMES if getattr(s, use) and s.names[0] not in {"-", "file"}
    )
    names = [name for scheme in SCHEMES for name in scheme.names if getattr(scheme, use)]
    near = [name for name in _LIKE.get(address.scheme, ()) if name in names]
    near = near or difflib.get_close_matches(address.scheme, names, 1)
    hint = f" - did you mean {near[0]}:?" if near else ""
    raise address.error(
        f"there is no scheme {address.scheme}:{hint}; there are {known}, a path, and - for a pipe"
    )


def _merged(options: ReadOptions, address: Address) -> ReadOptions:
    """Return the options with those of the URL put over them."""
    own: dict[str, Any] = {
        name: address.options[name] for name in ("unit", "skeleton") if name in address.options
    }
    if address.scheme != "demo" and "fps" in address.options:
        own["fps"] = address.number("fps", 0.001, 1e5)
    try:
        return msgspec.structs.replace(options, **own)
    except SettingsError as error:
        raise address.error(str(error)) from None


def _opener(place: str, *names: str) -> Callable[[Address, OpenOptions], Any]:
    """Return a function that opens a source or sink, and imports its module only then.

    Args:
        place: `MODULE:NAME` below `mossar_adapters`, a function of the address.
        names: Fields of `OpenOptions` that it takes besides, as keywords.
    """
    module, _, name = place.partition(":")

    def opened(address: Address, wanted: OpenOptions) -> Any:
        make = getattr(import_module(f"mossar_adapters.{module}"), name)
        return make(address, **{name: getattr(wanted, name) for name in names})

    return opened


def _demo(address: Address, wanted: OpenOptions) -> Source:
    from mossar_adapters.demo import DemoSource

    return DemoSource.from_url(address.url, speed=wanted.speed)


def _file(address: Address, wanted: OpenOptions) -> Source:
    from mossar_adapters.files.registry import open_recording
    from mossar_adapters.replay.recording_source import RecordingSource

    recording = open_recording(address.path, wanted.options)
    return RecordingSource(recording, wanted.speed, loop=wanted.loop)


def _file_sink(address: Address, wanted: OpenOptions) -> Sink:
    from mossar_adapters.annotations.sink import AnnotationSink
    from mossar_adapters.annotations.writing import SUFFIXES, has_format
    from mossar_adapters.jsonlines import JsonLinesSink
    from mossar_adapters.segment_csv import SegmentCsvSink

    match PurePath(address.path).suffix.lower():
        case ".jsonl" | ".ndjson":
            return JsonLinesSink(address, force=wanted.force, position=wanted.position)
        case ".csv":
            return SegmentCsvSink(address, force=wanted.force, position=wanted.position)
        case ".msk":
            raise address.error("a .msk recording holds frames, not events: mossar record SOURCE take.msk")
        case suffix if has_format(PurePath(address.path)):
            return AnnotationSink(address, force=wanted.force)
        case suffix:
            raise address.error(
                f"events go to .jsonl, segments to .csv, annotations to {' '.join(SUFFIXES)}, "
                f"not to {suffix or 'a file without ending'}"
            )


def _file_frame_sink(address: Address, wanted: OpenOptions) -> FrameSink:
    from mossar_adapters.jsonlines import JsonLinesFrameSink
    from mossar_adapters.replay.deferred_sink import DeferredSink
    from mossar_adapters.replay.msk_sink import MskFrameSink

    match PurePath(address.path).suffix.lower():
        case ".msk":
            if wanted.position:
                return MskFrameSink(address, position=wanted.position)
            force = wanted.force or wanted.position == 0  # a former run was not sure of anything in it
            return DeferredSink(address, lambda: MskFrameSink(address, force=force), force=force)
        case ".jsonl" | ".ndjson":
            return DeferredSink(
                address, lambda: JsonLinesFrameSink(address, force=wanted.force), force=wanted.force
            )
        case suffix:
            raise address.error(f"frames go to .msk or .jsonl, not to {suffix or 'a file without ending'}")


def _oak(address: Address, wanted: OpenOptions) -> Source:
    from mossar_adapters.oak.source import OakSource

    return OakSource.from_url(address.url, wanted.options)


def _webcam(address: Address, wanted: OpenOptions) -> Source:
    from mossar_adapters.pose.source import WebcamSource

    return WebcamSource.from_address(address, wanted.options, wanted.people)


SCHEMES: tuple[Scheme, ...] = (
    Scheme(("demo",), "demo:?seed=3", "the built-in performer", _demo),
    Scheme(("file",), "PATH", "recordings; events, segments", _file, _file_sink, _file_frame_sink),
    Scheme(
        ("-",),
        "-",
        "JSON lines through a pipe",
        _opener("jsonlines:JsonLinesSource", "options"),
        _opener("jsonlines:JsonLinesSink"),
        _opener("jsonlines:JsonLinesFrameSink"),
    ),
    Scheme(
        ("osc", "osc.udp"),
        "osc://HOST:PORT?profile=auto",
        "OSC over UDP",
        _opener("osc.source:OscSource", "options", "listener"),
        _opener("osc.event_sink:OscSink"),
        _opener("osc.frame_sink:open_osc_frame_sink"),
    ),
    Scheme(
        ("zmq", "zmq+bind", "ipc", "ipc+bind", "zmq+ipc", "zmq+bind+ipc"),
        "zmq://HOST:PORT, zmq+bind://HOST:PORT, ipc:///PATH, ipc+bind:///PATH",
        "ZeroMQ publish and subscribe",
        _opener("zeromq.source:ZmqSource", "options"),
        _opener("zeromq.sink:ZmqSink"),
        _opener("zeromq.sink:ZmqFrameSink"),
    ),
    Scheme(
        ("ws",),
        "ws://HOST:PORT",
        "WebSocket server for browsers",
        sink=_opener("websocket:WebSocketSink"),
        extra="web",
        library="websockets",
    ),
    Scheme(
        ("ws+bind",),
        "ws+bind://HOST:PORT",
        "frames from pages and programs that connect",
        _opener("websocket_source:WebSocketSource", "options"),
        extra="web",
        library="websockets",
    ),
    Scheme(
        ("lsl",),
        "lsl:?name=NAME",
        "Lab Streaming Layer",
        _opener("lsl:LslSource", "options"),
        _opener("lsl:LslSink"),
        extra="lsl",
        library="pylsl",
    ),
    Scheme(
        ("midi",),
        "midi:, midi:?port=NAME, midi:PATH",
        "MIDI notes and clock",
        sink=_opener("midi.sink:MidiSink", "force"),
        extra="midi",
        library="mido",
    ),
    Scheme(
        ("webcam",),
        "webcam:, webcam:1, webcam:?name=NAME",
        "webcams, estimated on this computer",
        _webcam,
        extra="webcam",
        library="ai_edge_litert",
    ),
    Scheme(("oak",), "oak:?device=ID", "Luxonis OAK cameras", _oak, extra="oak", library="depthai"),
)
