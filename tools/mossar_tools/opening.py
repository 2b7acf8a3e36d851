"""Opening: the source or sink of an argument."""

import logging
import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

import msgspec

from mossar_adapters.abilities import NamesPerformers, Notes, offered
from mossar_adapters.address import parse_url
from mossar_adapters.files import open_recording
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.live import Listener
from mossar_adapters.people import REMEMBERED
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Recording, Source
from mossar_adapters.urls import SCHEMES, open_frame_sink, open_sink, open_source
from mossar_tools.errors import UsageError
from mossar_tools.options import NOBODY, PageOptions, People, Speed

_log = logging.getLogger("mossar")
_HOST = re.compile(r"localhost|\d{1,3}(?:\.\d{1,3}){3}|\[[0-9a-fA-F:.]+\]")
_PORT = re.compile(r"(?:([\w.-]+|\[[0-9a-fA-F:.]+\]):)?(\d{1,6})")  # 39539, localhost:39539, [::1]:39539


def spelled_out(options: Any) -> Any:
    """Return a command's options with the URLs that ports, or addresses and ports, stand for; each is logged."""
    changed: dict[str, Any] = {}
    if hasattr(options, "sources"):
        changed["sources"] = tuple(_spelled_source(source) for source in options.sources)
    if hasattr(options, "to"):
        changed["to"] = tuple(_spelled_sink(sink) for sink in options.to)
    if hasattr(options, "streaming"):
        changed["streaming"] = spelled_out(options.streaming)
    return msgspec.structs.replace(options, **changed)


def _spelled_source(source: str) -> str:
    place = _port_of(source)
    if place is None:
        check_url(source)
        return source
    host, number = place
    url = f"osc://{host or '0.0.0.0'}:{number}"  # noqa: S104 - the sender is often another device
    where = f"on {host}" if host else "on all addresses of this computer"
    _log.info("%s is %s: OSC, %s; zmq://HOST:PORT is ZeroMQ", source, url, where)
    return url


def _spelled_sink(sink: str) -> str:
    place = _port_of(sink)
    if place is None:
        check_url(sink)
        return sink
    url = f"osc://{place[0] or '127.0.0.1'}:{place[1]}"
    _log.info("%s is %s: OSC", sink, url)
    return url


def is_port(text: str) -> bool:
    """Return whether this is a port, or an address and a port, and no URL."""
    return _port_of(text) is not None


def check_url(text: str) -> None:
    """Refuse a near URL: the name of a scheme, an address without a port, several sources in one word.

    Raises:
        UsageError: If it is one of these, and no file.
    """
    if parse_url(text).scheme != "file" or os.path.lexists(text):
        return
    forms = [scheme.form for scheme in SCHEMES if text in scheme.names and text != "file"]
    if forms:
        form = forms[0].partition("?")[0].partition(",")[0]
        raise UsageError(f"{text}: there is no such file - did you mean {form}?")
    if _HOST.fullmatch(text):
        raise UsageError(f"{text}: a port is missing, as in {text}:39539")
    parts = text.split(",")
    if len(parts) > 1 and all(part == "-" or _port_of(part) or Path(part).exists() for part in parts):
        raise UsageError(f"{text}: several are separated by spaces: {' '.join(parts)}")


def _port_of(text: str) -> tuple[str, str] | None:
    """Return host and port of a text that is no URL and no file, but a port; the host may be empty."""
    found = _PORT.fullmatch(text)
    if found is None or Path(text).exists():
        return None
    host = found[1] or ""
    if any(host in scheme.names for scheme in SCHEMES):
        if host != "osc":
            return None
        host = ""
    if int(found[2]) > 65535:
        raise UsageError(f"{text}: a port lies between 0 and 65535, as in {text.removesuffix(found[2])}39539")
    return "127.0.0.1" if host == "localhost" else host, found[2]


def which_source(command: str, page: PageOptions) -> str:
    """Return what to say where the source of a stream is missing; a port may have been given instead."""
    if page.port != PageOptions().port:
        return f"which source? --port is the port of the page; to listen there: mossar {command} {page.port}"
    return (
        f"which source? A port, a URL, a recording, or -: mossar {command} 39539, mossar {command} take.bvh"
    )


def command_for(text: str) -> str | None:
    """Return the command that processes a source or recording that was given without one; None if it is neither."""
    if _port_of(text) is not None or text == "-":
        return "run"
    if parse_url(text).scheme != "file":
        return "run" if any(parse_url(text).scheme in scheme.names for scheme in SCHEMES) else None
    from mossar_adapters.files import FORMATS

    endings = tuple(ending for form in FORMATS for ending in form.extensions)
    return "segment" if Path(text).is_file() or text.lower().endswith(endings) else None


def source_of(
    url: str,
    reading: ReadOptions,
    people: People = NOBODY,
    speed: Speed = None,
    listener: Listener | None = None,
    *,
    loop: bool = False,
) -> Source:
    """Return the source that a URL or path stands for, and log the notes of its opening.

    Args:
        url: As on the command line.
        reading: How a recording is read.
        people: Slots instead of the sender's ids.
        speed: Of a recording or demo:, as a multiple of real time; None for the usual one.
        listener: Gets messages that are no frames.
        loop: Whether to repeat a recording.

    Raises:
        MossarError: If it cannot be opened.
    """
    address = parse_url(url)
    scheme = address.scheme
    if loop and scheme == "demo" and "seconds" in address.options:
        raise UsageError(f"{url}: --loop is for recordings; demo: is endless without seconds=")
    if speed is not None and scheme not in {"demo", "file"}:
        raise UsageError(f"{url}: --speed is for recordings and demo:; live frames have their own")
    source = open_source(
        url,
        options=reading,
        speed=speed or (1.0 if scheme == "demo" else "max"),
        listener=listener,
        loop=loop,
        people=people.people,
        remember=REMEMBERED if people.remember is None else people.remember,
    )
    _check_performer(source, reading.performer)
    noted = offered(source, Notes)
    _log_notes(source.name, () if noted is None else noted.notes)
    return source


def _check_performer(source: Source, wanted: str | None) -> None:
    """Refuse a performer of whom a source knows that they will never come."""
    named = offered(source, NamesPerformers)
    performers = () if named is None else named.performers
    if wanted is not None and named is not None and wanted not in performers:
        source.close()
        raise UsageError(
            f"{source.name}: no performer called {wanted[:40]!r}; there are {', '.join(performers[:40])}"
        )


def recording_of(url: str, reading: ReadOptions) -> Recording:
    """Return the recording that a path stands for, and log the notes of its reader.

    Raises:
        FileError: If it cannot be read.
    """
    recording = open_recording(parse_url(url).path, reading)
    _log_notes(recording.path, recording.notes)
    return recording


def sink_of(url: str, positions: Mapping[str, int | None], *, force: bool) -> Sink | FrameSink:
    """Return the sink that a URL or path stands for: of events, or of frames for a recording.

    Args:
        url: As on the command line.
        positions: Bytes written by a former run, by the names of sinks that go on.
        force: Whether a file may be replaced.

    Raises:
        MossarError: If it cannot be opened.
    """
    position = positions.get(parse_url(url).url)
    if PurePath(parse_url(url).path).suffix.lower() == ".msk":
        return open_frame_sink(url, force=force, position=position)
    return open_sink(url, force=force, position=position)


def _log_notes(name: str, notes: tuple[str, ...]) -> None:
    for note in notes:
        _log.info("%s", note if note.startswith(name) else f"{name}: {note}")
