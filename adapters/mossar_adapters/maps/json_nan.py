"""JSON as Python's own module writes it: with NaN and Infinity, which JSON has no words for."""

import re

_TEXT_OR_WORD = re.compile(rb'"(?:[^"\\]++|\\.)*+"?|-?\b(?:NaN|Infinity)\b', re.DOTALL)

_QUOTE = ord('"')


def without_nan(data: bytes) -> bytes | None:
    """Return JSON with null for NaN and Infinity, None if they are not in it.

    Example:
        >>> without_nan(b'[NaN, "NaN", -Infinity]')
        b'[null, "NaN", null]'
    """
    if b"NaN" not in data and b"Infinity" not in data:
        return None
    plain, done = bytearray(), 0
    for found in _TEXT_OR_WORD.finditer(data):  # not sub, which keeps all pieces until the end
        if data[found.start()] != _QUOTE:
            plain += data[done : found.start()]
            plain += b"null"
            done = found.end()
    return bytes(plain + data[done:])
