"""OSC datagrams taken apart into messages, in the order in which they were written.

Numbers, text and blobs, which come by the thousand, are read here; python-osc reads all other arguments. Bundles are
walked here, because its own walk sorts by time tags, which shuffles the bundles of a sender with a skewed clock. It
also never ends on a negative size. Time tags are ignored. NI mate sends addresses without the leading slash.
"""

import functools
import math
import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from pythonosc.osc_message import OscMessage, ParseError

from mossar_adapters.files.cells import LARGEST
from mossar_stream import FrameError

MAX_DEPTH = 8  # bundles within bundles
_REMEMBERED = 512  # bytes; longer headers are not kept, or strangers could fill the memory with them
_BUNDLE = b"#bundle\0"
_BUNDLE_HEAD = 16  # bytes: the word and the time tag
_SIZES = {"i": 4, "f": 4, "s": 4, "b": 4, "h": 8, "d": 8, "t": 8, "r": 4, "m": 4} | dict.fromkeys("TFN[]", 0)
# An address without a slash, and type tags.
_BARE = re.compile(rb"[A-Za-z][\x20-\x2b\x2d-\x7e]{0,80}\0{1,4},")
_int32 = struct.Struct(">i")


def messages(datagram: bytes) -> Iterable[tuple[str, Sequence[Any]]]:
    """Return address and arguments of each message in a datagram, to be gone through once.

    Raises:
        FrameError: If the datagram is damaged or has arguments of an unknown type; the messages before the
            damage are there.
    """
    return (_message(datagram),) if _is_message(datagram) else _walk(datagram, 0)


def numbers(arguments: Sequence[Any], start: int, count: int) -> tuple[float, ...]:
    """Return `count` arguments from `start` on as numbers; integers, floats and doubles are all welcome.

    NaN passes; numbers that are infinite, or have an infinite square, become NaN.

    Raises:
        FrameError: If there are fewer, or one is no number.
    """
    return numbers_at(arguments, range(start, start + count))


def numbers_at(arguments: Sequence[Any], places: Sequence[int]) -> tuple[float, ...]:
    """Return the arguments at the given places as numbers, see `numbers`.

    Raises:
        FrameError: If there are fewer, or one is no number.
    """
    try:
        found = [arguments[place] for place in places]
    except IndexError:
        raise FrameError(f"{len(arguments)} arguments are too few; {max(places) + 1} are needed") from None
    for value in found:
        if type(value) is not float and type(value) is not int:
            raise FrameError(f"argument {value!r} is no number"[:100])
    return tuple([value if -LARGEST < value < LARGEST else math.nan for value in found])


def whole_number(value: Any) -> int:
    """Return an id as a whole number; programs that know only floats send 1.0.

    Raises:
        FrameError: If it is no whole number.
    """
    if type(value) is int:
        return value
    if type(value) is float and value.is_integer():
        return int(value)
    raise FrameError(f"{value!r} is no whole number"[:100])


def word(arguments: Sequence[Any], place: int) -> str:
    """Return an argument that must be text.

    Raises:
        FrameError: If it is none.
    """
    if len(arguments) <= place or not isinstance(arguments[place], str):
        raise FrameError(f"argument {place} is no text")
    return str(arguments[place])


def _walk(packet: bytes, depth: int) -> Iterator[tuple[str, Sequence[Any]]]:
    if _is_message(packet):
        yield _message(packet)
        return
    if packet[:8] != _BUNDLE or len(packet) < _BUNDLE_HEAD:
        raise FrameError("this is no OSC packet")
    if depth == MAX_DEPTH:
        raise FrameError(f"more than {MAX_DEPTH} bundles within each other")
    at = _BUNDLE_HEAD
    while at < len(packet):
        size = _int32.unpack_from(packet, at)[0] if at + 4 <= len(packet) else -1
        at += 4
        if not 0 < size <= len(packet) - at:
            raise FrameError("a bundle is cut off or damaged")
        yield from _walk(packet[at : at + size], depth + 1)
        at += size


def _is_message(packet: bytes) -> bool:
    """Return whether a packet begins like a message: with an address, which may lack the slash."""
    if packet[:1] == b"/":
        return True
    bare = _BARE.match(packet)
    return bare is not None and bare.end() % 4 == 1


def _message(packet: bytes) -> tuple[str, Sequence[Any]]:
    tags_at = (packet.find(b"\0") // 4 + 1) * 4
    tags_end = packet.find(b"\0", tags_at)
    if packet[tags_at : tags_at + 1] != b"," or tags_end < 0:
        if 0 < tags_at == len(packet):  # an address alone: old senders leave out empty tags
            return packet.rstrip(b"\0").decode("utf-8", "replace"), ()
        raise FrameError("a message has no type tags")
    at = (tags_end // 4 + 1) * 4
    try:
        read = _layout if tags_end < _REMEMBERED else _layout.__wrapped__
        layout = read(packet[: tags_end + 1], tags_at)
        if at + layout.size > len(packet):
            raise FrameError("a message is cut off")
        if layout.parts is not None:
            return layout.address, _arguments(packet, at, layout.parts)
        return layout.address, OscMessage(packet).params
    except (ParseError, ValueError, IndexError, OverflowError, struct.error) as error:
        raise FrameError(f"damaged OSC message: {error}"[:200]) from None


class _Layout(NamedTuple):
    """The layout of a message by its address and tags.

    Args:
        address: With the leading slash, if the sender gives one.
        size: Least number of bytes of the arguments; python-osc would fill in zeros.
        parts: Structs for runs of numbers, else the tag; None altogether if python-osc is to read it.
    """

    address: str
    size: int
    parts: tuple[struct.Struct | str, ...] | None


@functools.lru_cache(maxsize=4096)
def _layout(header: bytes, tags_at: int) -> _Layout:
    """Return the layout of messages that begin alike; they come by the thousand.

    Raises:
        FrameError: If a tag is unknown; python-osc would pass over it and shift the others.
    """
    address = header[: header.index(b"\0")].decode()
    tags = header[tags_at + 1 : -1].decode("latin-1")
    for tag in tags:
        if tag not in _SIZES:
            raise FrameError(f"unknown type tag {tag!r}")
    parts = None
    if not set(tags) - set("ifhdsb"):
        runs = re.findall("s|b|[ifhd]+", tags)
        parts = tuple(run if run in "sb" else _struct(run) for run in runs)
    return _Layout(address, sum(_SIZES[tag] for tag in tags), parts)


def _struct(run: str) -> struct.Struct:
    """Return the reader of a run of numbers; `>150f` takes 30 bytes, `>ffff...` would take as many for each number."""
    counted = re.sub(r"(.)\1*", lambda found: f"{len(found[0])}{found[1]}", run)
    return struct.Struct(">" + counted.replace("h", "q"))


def _arguments(packet: bytes, at: int, parts: Sequence[struct.Struct | str]) -> Sequence[Any]:
    found: list[Any] = []
    for part in parts:
        if not isinstance(part, str):
            found += part.unpack_from(packet, at)
            at += part.size
        elif part == "s":
            end = packet.index(b"\0", at)
            found.append(packet[at:end].decode())
            at = (end // 4 + 1) * 4
        else:
            size = _int32.unpack_from(packet, at)[0]
            at += 4
            if not 0 <= size <= len(packet) - at:
                raise FrameError("a message is cut off")
            found.append(packet[at : at + size])
            at += (size + 3) // 4 * 4
    return found
