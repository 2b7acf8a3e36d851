"""OSC messages and bundles as bytes: the types our sinks send, packed at once."""

import struct
from collections.abc import Iterator, Sequence

BUNDLE_HEAD = b"#bundle\0" + struct.pack(">Q", 1)  # 1 stands for "at once"
MAX_BUNDLE = 1400  # bytes; fits one Ethernet packet together with its headers


def encode(address: str, tags: str, *arguments: float | str | bytes) -> bytes:
    r"""Return one message.

    Args:
        address: With the leading slash.
        tags: One letter of `ifdhsb` per argument.
        arguments: Numbers are converted by their tag; integers are kept within 32 bits.

    Example:
        >>> encode("/a", "si", "hi", 7)
        b'/a\x00\x00,si\x00hi\x00\x00\x00\x00\x00\x07'
    """
    parts = [_text(address), _text("," + tags)]
    for tag, argument in zip(tags, arguments, strict=True):
        parts.append(_argument(tag, argument))
    return b"".join(parts)


def bundle(messages: Sequence[bytes]) -> bytes:
    """Return messages or bundles as one bundle."""
    parts = [BUNDLE_HEAD]
    for message in messages:
        parts += (struct.pack(">i", len(message)), message)
    return b"".join(parts)


def bundles(messages: Sequence[bytes]) -> Iterator[bytes]:
    """Yield messages as bundles of up to `MAX_BUNDLE` bytes."""
    waiting: list[bytes] = []
    size = len(BUNDLE_HEAD)
    for message in messages:
        if waiting and size + 4 + len(message) > MAX_BUNDLE:
            yield bundle(waiting)
            waiting, size = [], len(BUNDLE_HEAD)
        waiting.append(message)
        size += 4 + len(message)
    if waiting:
        yield bundle(waiting)


def _argument(tag: str, argument: float | str | bytes) -> bytes:
    if isinstance(argument, str):
        return _text(argument)
    if isinstance(argument, bytes):
        return struct.pack(">i", len(argument)) + argument + b"\0" * (-len(argument) % 4)
    if tag == "i":
        return struct.pack(">i", min(max(int(argument), -(2**31)), 2**31 - 1))
    if tag == "f" and not -3.4e38 < argument < 3.4e38:
        return struct.pack(">f", float("nan"))
    return struct.pack(">" + {"f": "f", "d": "d", "h": "q"}[tag], argument)


def _text(text: str) -> bytes:
    data = text.replace("\0", "").encode("utf-8", "replace")
    return data + b"\0" * (4 - len(data) % 4)
