"""Opening: what a source or sink on the command line stands for."""

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Source
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.options import Options

EVENT_FILES: Final = (".jsonl", ".csv", ".msk")

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # two letters or more: C:\take.bvh is a path

Speed = float | Literal["max"]


def scheme_of(url: str) -> str:
    """Return the scheme of a URL in lower case; `file` for a path, `-` for standard input or output."""
    if url == "-":
        return url
    found = _SCHEME.match(url)
    return found[1].lower() if found else "file"


def path_of(url: str) -> Path:
    """Return the path that a `file:` URL or a plain path stands for."""
    return Path(re.sub(r"^file:(//(?=/))?", "", url, flags=re.IGNORECASE))


def open_source(url: str, options: Options) -> Source:
    """Return the source that a URL or path stands for.

    Raises:
        MossarError: If it cannot be opened.
    """
    scheme = scheme_of(url)
    if scheme == "file":
        from mossar_adapters.recorded import RecordedSource

        return RecordedSource(open_recorded(url, options), speed=options.speed or "max", loop=options.loop)
    from mossar_adapters.selecting import SelectingSource

    source = _open_live(url, scheme, options)
    if not (options.joints or options.root or options.performer):
        return source
    return SelectingSource(source, joints=options.joints, root=options.root, performer=options.performer)


def open_recorded(url: str, options: Options):
    """Return the recording that a path stands for, and say what its reader found out.

    Raises:
        FileError: If it cannot be read.
    """
    from mossar_adapters.files import open_recording

    recording = open_recording(path_of(url), options.reading())
    for note in recording.notes:
        LOGGER.info("%s: %s", recording.path, note)
    return recording


def open_sink(url: str, positions: Mapping[str, int]) -> Sink | FrameSink:
    """Return the sink that a URL or path stands for.

    Args:
        url: As on the command line.
        positions: Bytes written by a former run, for files that it goes on with.

    Raises:
        MossarError: If it cannot be opened.
    """
    from mossar_adapters.event_files import JsonLinesSink, RecordingSink, SegmentCsvSink

    scheme = scheme_of(url)
    if scheme == "-":
        return JsonLinesSink(sys.stdout.buffer, "standard output", owned=False)
    if scheme != "file":
        from mossar_adapters import urls

        return urls.open_sink(url)
    path = path_of(url)
    match path.suffix.lower():
        case ".jsonl":
            return JsonLinesSink.open(path, positions.get(str(path)))
        case ".csv":
            return SegmentCsvSink.open(path, positions.get(str(path)))
        case ".msk":
            return RecordingSink(path)
        case suffix:
            raise UsageError(
                f"{url}: events cannot be written as {suffix or 'that'}; use {' '.join(EVENT_FILES)}"
            )


def _open_live(url: str, scheme: str, options: Options) -> Source:
    if scheme == "demo":
        from mossar_adapters.demo import DemoSource

        return DemoSource.from_url(url, speed=options.speed or 1.0)
    if scheme == "-":
        from mossar_adapters.standard_input import JsonLinesSource

        return JsonLinesSource(fps=options.fps)
    if options.speed is not None:
        raise UsageError(f"{url}: --speed is for recordings and demo:, live frames have their own")
    from mossar_adapters import urls

    return urls.open_source(url)
