"""Lines of a text log of OSC messages, as liblo's `oscdump` prints them and `oscsendfile` plays them.

A line is a time, an address, type tags and the arguments: `ee86d8c4.1eb851e1 /joint sifff "head" 1 0.5 1.2 2.0`.
The time is an NTP time tag in hexadecimal, seconds and their 2^-32 parts; programs older than 2018 leave it out.
Addresses without the slash, as NI mate sends them, count in lines with a time.
Text stands in quotes and nothing in it is escaped. Blobs of more than 12 bytes are printed as their size only.
"""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

_LINE = re.compile(
    r"(?:([0-9a-f]{8})\.([0-9a-f]{8})\s+)?(/\S*|(?<=\s)[a-z][\w.-]*)(?:\s+([a-zA-Z]+)(?:\s+(.*))?)?\s*",
    re.IGNORECASE,
)
_WORD = re.compile(r"(\S+)(?:\s+|$)")
_FIXED = {"T": True, "F": False, "N": None, "I": float("inf")}
_PATTERNS = {
    "s": re.compile(r'"(.*?)"(?:\s+|$)'),
    "S": re.compile(r"'(.*?)'?(?:\s+|$)"),
    "c": re.compile(r"'(.)'(?:\s+|$)"),
    "b": re.compile(r"\[(.*?)\](?:\s+|$)"),
    "m": re.compile(r"MIDI \[(.*?)\](?:\s+|$)"),
}
HIDDEN = b"?"  # stands for a blob that is printed as its size
_AT_ONCE = (0, 1)  # the time tag that stands for no time


class LogMessage(NamedTuple):
    """One line: the time in s since 1900, or None, the address and the arguments."""

    time: float | None
    address: str
    arguments: tuple[Any, ...]


def log_message(line: str) -> LogMessage | None:
    """Return the message in a line of a log, or None if there is none.

    Args:
        line: Without its end.

    Example:
        >>> log_message('83aa7e80.80000000 /joint sif "head" 1 0.5')
        LogMessage(time=2208988800.5, address='/joint', arguments=('head', 1, 0.5))
    """
    found = _LINE.fullmatch(line)
    if found is None:
        return None
    try:
        arguments = _arguments(found[4] or "", found[5] or "")
    except ValueError:
        return None
    return LogMessage(_time(found[1], found[2]), found[3], arguments)


def is_cut(line: str) -> bool:
    """Return whether a last line that has no end misses something: numbers have six digits behind the point."""
    return log_message(line) is None or bool(re.search(r"\.\d{0,5}$", line))


def _time(seconds: str | None, parts: str | None) -> float | None:
    if seconds is None or parts is None:
        return None
    tag = int(seconds, 16), int(parts, 16)
    return None if tag == _AT_ONCE else tag[0] + tag[1] / 2**32


def _arguments(tags: str, text: str) -> tuple[Any, ...]:
    """Return the arguments that the type tags announce.

    Raises:
        ValueError: If the text does not fit the tags.
    """
    words = text.split()
    if len(words) == len(tags) and not set(tags) - {"i", "h", "f", "d"}:
        return tuple([_READ[tag](word) for tag, word in zip(tags, words, strict=True)])
    found, at = [], 0
    for tag in tags:
        match = _PATTERNS.get(tag, _WORD).match(text, at)
        if match is None:
            raise ValueError(tag)
        found.append(_READ[tag](match[1]) if tag in _READ else _other(tag, match[1]))
        at = match.end()
    if text[at:].strip():
        raise ValueError(text)
    return tuple(found)


def _other(tag: str, word: str) -> object:
    if tag in _FIXED:
        return _FIXED[tag]
    if tag not in "sSctmb":
        raise ValueError(tag)
    if word.endswith(" byte blob"):
        return HIDDEN
    return bytes(int(part, 16) for part in word.split()) if tag in "mb" else word


_READ: dict[str, Callable[[str], float]] = {"i": int, "h": int, "f": float, "d": float}
