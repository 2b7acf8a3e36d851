"""Text logs of OSC messages (`oscdump -L 9000 > take.osc`), decoded by the profiles that live messages go through."""

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.address import Address
from mossar_adapters.files.assembly import sane_frames
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.osc_lines import HIDDEN, LogMessage, is_cut, log_message
from mossar_adapters.files.rates import rate_of_times
from mossar_adapters.files.rows import CHUNK
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines
from mossar_adapters.live import Counters
from mossar_adapters.osc.profiles.profile import NOTHING, Context, Items, Message
from mossar_adapters.osc.profiles.routes import Routes
from mossar_adapters.receiving.batch import Batch
from mossar_adapters.receiving.senders import Senders
from mossar_adapters.source import Departure, Meta, Recording
from mossar_stream import FrameError, Frames, Skeleton

USUAL_FPS = 60.0
_AT_A_TIME = 4096  # messages between two looks for frames
_TICK = 0.004  # s between two messages in which a live source would look for frames that are over
_SILENCE = 60.0  # s after the last message, so that every open frame is over
_KINDS = 16  # kinds of unknown messages kept to be named


class Log(msgspec.Struct):
    """The findings of a pass over the log, besides frames.

    Args:
        counters: Counters, as of a live source.
        unwanted: Messages that fit no profile, by address.
        blobs: Messages with a blob that the log does not show.
        strange: Lines that are no messages.
        cut: Whether the last line was cut off.
        timed: Whether the messages have times.
        clocks: Problems of the senders' clocks.
    """

    counters: Counters = msgspec.field(default_factory=Counters)
    unwanted: Counter[str] = msgspec.field(default_factory=Counter)
    blobs: int = 0
    strange: int = 0
    cut: bool = False
    timed: bool = False
    clocks: list[str] = msgspec.field(default_factory=list)


def read(path: Path, options: ReadOptions) -> Recording:
    """Read a log of OSC messages.

    All performers share a skeleton, the one with the most frames; frames with only some of its joints get
    missing ones for the others.

    Raises:
        FileError: If no profile finds a frame in it.
    """
    log, first_times = Log(), dict[str, list[float]]()
    counts = Counter[tuple[str, Skeleton, str]]()
    for meta, frames in _poses(path, options, log):
        counts[frames.performer, meta.skeleton, meta.unit] += len(frames)
        times = first_times.setdefault(frames.performer, [])
        times += frames.times[: CHUNK - len(times)].tolist()
    if not counts:
        raise FileError(path, _no_frame(log))
    (chosen, skeleton, unit), _ = max(
        counts.items(), key=lambda item: (item[0][0] == options.performer, item[1])
    )
    fitting = {key: n for key, n in counts.items() if set(key[1].names) <= set(skeleton.names)}
    clock = options.fps or (None if log.timed else USUAL_FPS)
    left_out = counts.total() - sum(fitting.values())
    notes = _notes(log, clock, unit, left_out, guessed=clock is not None and options.fps is None)

    def chunks() -> Iterator[Frames]:
        return _chunks(path, options, skeleton, clock)

    fps = clock or rate_of_times(np.array(first_times[chosen]))
    performers = tuple(dict.fromkeys(name for name, _, _ in fitting))
    return Recording(str(path), skeleton, fps, chunks, notes, sum(fitting.values()), performers)


def _chunks(path: Path, options: ReadOptions, skeleton: Skeleton, clock: float | None) -> Iterator[Frames]:
    """Yield the frames that fit a skeleton; times from the log, or counted at `clock` Hz if that is given."""
    done = Counter[str]()
    for meta, frames in _poses(path, options, Log()):
        names = meta.skeleton.names
        if not set(names) <= set(skeleton.names):
            continue
        places = [skeleton.index(name) for name in names]
        positions = _spread(frames.positions, places, len(skeleton), np.nan)
        confidence = frames.confidence
        if confidence is not None:
            confidence = _spread(confidence, places, len(skeleton), 0.0)
        times = frames.times
        if clock is not None:
            times = (done[frames.performer] + np.arange(len(frames))) / clock
        done[frames.performer] += len(frames)
        yield sane_frames(positions, times, confidence, frames.performer)


def _spread(
    values: NDArray[np.float32], places: list[int], joints: int, missing: float
) -> NDArray[np.float32]:
    """Return (n, joints, …) with the values (n, k, …) at k places."""
    spread = np.full((len(values), joints, *values.shape[2:]), missing, np.float32)
    spread[:, places] = values
    return spread


def _poses(path: Path, options: ReadOptions, log: Log) -> Iterator[tuple[Meta, Frames]]:
    """Yield chunks of frames with the announcement that they follow."""
    metas: dict[str, Meta] = {}
    for item in _items(path, options, log):
        if isinstance(item, Meta):
            metas[item.performer] = item
        elif isinstance(item, Frames):  # departures are not recorded
            yield metas[item.performer], item


def _items(path: Path, options: ReadOptions, log: Log) -> Iterator[Meta | Frames | Departure]:
    batch = Batch(None, log.counters, log.clocks.append)
    address = Address(str(path), "file", path=str(path))
    routes = Routes("auto", Context(address, options, Senders(), log.counters))
    now = 0.0
    for count, message in enumerate(_messages(path, log), 1):
        if message.arrival - now > _TICK:
            _collect(batch, routes.idle(message.arrival), log)
        now = max(now, message.arrival)
        _collect(batch, _decoded(routes, message, log), log)
        if count % _AT_A_TIME == 0:
            yield from batch.take()
    _collect(batch, routes.idle(now + _SILENCE), log)
    yield from batch.take(math.inf)


def _messages(path: Path, log: Log) -> Iterator[Message]:
    """Yield the messages, with s since the first one as arrival; 0 where the log has no times."""
    begin: float | None = None
    arrival = 0.0
    for found in _found(path, log):
        if found.time is not None:
            begin = found.time if begin is None else begin
            arrival = found.time - begin
            log.timed = True
        log.counters.received += 1
        log.blobs += HIDDEN in found.arguments
        yield Message(found.address, found.arguments, "", arrival)


def _found(path: Path, log: Log) -> Iterator[LogMessage]:
    """Yield the lines that are messages, without the last one if it was cut off."""
    whole = not ends_in_mid_line(path)
    ahead = ""  # the latest line, kept until it is known not to be the last one
    for _, line in numbered_lines(path):
        if ahead:
            yield from _parsed(ahead, log)
        ahead = "" if line.isspace() or line.startswith("#") else line
    log.cut = bool(ahead) and not whole and is_cut(ahead)
    if ahead and not log.cut:
        yield from _parsed(ahead, log)


def _parsed(line: str, log: Log) -> Iterator[LogMessage]:
    found = log_message(line)
    if found is None:
        log.strange += 1
    else:
        yield found


def _decoded(routes: Routes, message: Message, log: Log) -> Items:
    try:
        found = routes.receive(message)
    except FrameError as error:
        log.counters.reject(f"{message.address[:60]}: {error}")
        return NOTHING
    if found is None:
        log.counters.ignored += 1
        if message.address in log.unwanted or len(log.unwanted) < _KINDS:
            log.unwanted[message.address] += 1
    return found or NOTHING


def _collect(batch: Batch, found: Items, log: Log) -> None:
    for item in found:
        try:
            batch.put(item)
        except FrameError as error:
            log.counters.reject(str(error))


def _notes(log: Log, clock: float | None, unit: str, left_out: int, *, guessed: bool) -> tuple[str, ...]:
    """Return notes for the user; frames are counted at `clock` Hz if that is given."""
    counters = log.counters
    said = {
        f"rate taken as {clock} Hz (the log has no times); set --fps to change": guessed,
        unit: unit != "m",
        f"{left_out} frames with another skeleton are left out": left_out,
        f"{log.strange} lines are no messages": log.strange,
        f"{counters.malformed} messages could not be used, the last: {counters.last_error}": counters.malformed,
        "the file is cut off in its last message": log.cut,
    }
    return (*(note for note, apt in said.items() if apt), *(() if clock else log.clocks))


def _no_frame(log: Log) -> str:
    """Return the reason why a log has no frame, and its other content."""
    counters = log.counters
    if counters.malformed:
        hint = " (oscdump leaves out the content of blobs; record with mossar record)" if log.blobs else ""
        return f"no frame in {counters.received} messages, the last: {counters.last_error}{hint}"
    kinds = ", ".join(shown(address) for address, _ in log.unwanted.most_common(4))
    return f"none of {counters.received} messages is of a known profile of OSC; there are {kinds or 'none'}"
