"""Opening: what a source or sink on the command line stands for."""

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

from mossar_adapters.address import Address, parse_url
from mossar_adapters.pipeline.listening import Ears
from mossar_adapters.sink import FrameSink, Sink
from mossar_adapters.source import Recording, Source
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.options import Options

EVENT_FILES: Final = (".jsonl", ".csv", ".msk")

Speed = float | Literal["max"]


def open_source(url: str, options: Options, ears: Ears | None = None) -> Source:
    """Return the source that a URL or path stands for.

    Raises:
        MossarError: If it cannot be opened.
    """
    address = parse_url(url)
    if address.scheme == "file":
        from mossar_adapters.recorded import RecordedSource

        return RecordedSource(open_recorded(url, options), speed=options.speed or "max", loop=options.loop)
    from mossar_adapters.selecting import SelectingSource

    source = _open_live(address, options, ears)
    if not (options.joints or options.root or options.performer):
        return source
    return SelectingSource(source, joints=options.joints, root=options.root, performer=options.performer)


def open_recorded(url: str, options: Options) -> Recording:
    """Return the recording that a path stands for, and say what its reader found out.

    Raises:
        FileError: If it cannot be read.
    """
    from mossar_adapters.files import open_recording

    recording = open_recording(parse_url(url).path, options.reading())
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

    address = parse_url(url)
    if address.scheme == "-":
        return JsonLinesSink(sys.stdout.buffer, "standard output", owned=False)
    if address.scheme != "file":
        from mossar_adapters import urls

        return urls.open_sink(url)
    path = Path(address.path)
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


def _open_live(address: Address, options: Options, ears: Ears | None) -> Source:
    scheme, url = address.scheme, address.url
    if scheme == "demo":
        from mossar_adapters.demo import DemoSource

        return DemoSource.from_url(url, speed=options.speed or 1.0)
    if scheme == "-":
        from mossar_adapters.standard_input import StandardInput

        return StandardInput(options.reading())
    if options.speed is not None:
        raise UsageError(f"{url}: --speed is for recordings and demo:, live frames have their own")
    from mossar_adapters import urls

    return urls.open_source(url, options.reading(), ears)
