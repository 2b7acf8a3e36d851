"""Loaded recordings: all frames of a recording, or of a built-in performance, in memory."""

import msgspec

from mossar_adapters.address import parse_url
from mossar_adapters.demo import Cut, DemoSource
from mossar_adapters.files.loaded import LoadedRecording, OnProgress, load
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.selection import selected
from mossar_adapters.source import Meta, Recording
from mossar_stream import Frames
from mossar_tools.console import LOGGER
from mossar_tools.errors import UsageError
from mossar_tools.opening import check_url, is_port, recording_of, source_of
from mossar_tools.options import NOBODY, People

AS_IT_IS = ReadOptions()
DEMO_SECONDS = 30  # of motion, unless the URL sets it
_CHUNK_CUTS = 8  # more than lie in one chunk of a performance


def load_recording(
    file: str,
    reading: ReadOptions = AS_IT_IS,
    on_progress: OnProgress = lambda _: None,
    *,
    people: People = NOBODY,
    begin: float | None = None,
    until: float | None = None,
) -> LoadedRecording:
    """Return a recording or a built-in performance, or a part of it.

    Args:
        file: Its path, or the URL of the performance.
        reading: How it is read.
        on_progress: Gets the share that is read.
        people: Slots instead of the ids in the file.
        begin: Of the part, s of the recording's clock.
        until: End of the part, s of the recording's clock.

    Raises:
        MossarError: If it cannot be read, or is too large to be held in memory.
    """
    scheme = "osc" if is_port(file) else parse_url(file).scheme
    if scheme not in {"demo", "file"}:
        raise UsageError(
            f"{file} is a stream, which mossar run takes; this command takes a recording or demo:"
        )
    check_url(file)
    cuts: dict[str, tuple[Cut, ...]] = {}
    if scheme == "demo":
        recording = _performance(file, reading, cuts)
    elif people.people is not None:
        recording = _of_slots(file, reading, people)
    else:
        recording = recording_of(file, reading)
    if len(recording.performers) > 1 and reading.performer is None:
        LOGGER.info(
            "%s: performer %s is taken; there are %s (--performer)",
            recording.path,
            recording.performers[0],
            ", ".join(recording.performers),
        )
    loaded = load(recording, on_progress)
    loaded = msgspec.structs.replace(loaded, cuts=cuts.get(loaded.performer, ()))
    return loaded if begin is until is None else loaded.part(begin, until)


def _of_slots(file: str, reading: ReadOptions, people: People) -> Recording:
    """Return a recording whose performers are the slots of `--people`.

    Raises:
        UsageError: If it has no performer.
    """
    source = source_of(file, reading, people)
    metas: dict[str, Meta] = {}
    chunks: list[Frames] = []
    for item in source.items():
        if isinstance(item, Meta):
            metas.setdefault(item.performer, item)
        elif isinstance(item, Frames):
            chunks.append(item)
    names = tuple(sorted({chunk.performer for chunk in chunks}, key=lambda name: (len(name), name)))
    if not names:
        raise UsageError(f"{file}: there is nobody in it")
    meta = metas[names[0]]
    return Recording(file, meta.skeleton, meta.fps, lambda: iter(chunks), performers=names)


def _performance(url: str, reading: ReadOptions, cuts: dict[str, tuple[Cut, ...]]) -> Recording:
    """Return the built-in performance as a recording, and put its true cuts into `cuts`."""
    if "seconds=" not in url and "moves=" not in url:
        url += f"{'&' if '?' in url else '?'}seconds={DEMO_SECONDS}"
    source = DemoSource.from_url(url, speed="max")
    metas: list[Meta] = []
    chunks: list[Frames] = []
    known: dict[str, dict[int, Cut]] = {}
    for item in source.items():
        if isinstance(item, Meta):
            metas.append(item)
        elif isinstance(item, Frames):
            chunks.append(item)
            # Of a long performance the source remembers the last cuts only.
            newest = source.cuts[item.performer][-_CHUNK_CUTS:]
            known.setdefault(item.performer, {}).update((cut.frame, cut) for cut in newest)
    cuts.update((performer, tuple(found.values())) for performer, found in known.items())
    names = tuple(meta.performer for meta in metas)
    whole = Recording(url, metas[0].skeleton, metas[0].fps, lambda: iter(chunks), performers=names)
    return selected(whole, reading)
