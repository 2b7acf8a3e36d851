"""Lines of text files of unknown origin: encodings, line numbers, bounded memory."""

import codecs
from collections.abc import Iterator
from pathlib import Path

from mossar_adapters.files.errors import FileError

HEAD_SIZE = 65536
MAX_LINE = 4 << 20  # characters; the widest marker files known have lines of some ten thousand

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_PADDING = b"\0\x1a"  # bytes that a crash or an old program leaves behind the text


def encoding_of(head: bytes) -> str | None:
    """Return the encoding of a file that begins with `head`, or None if it is not text."""
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    head = head.rstrip(_PADDING)
    if b"\0" in head:
        return _unmarked_utf16(head)
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)  # a character may be cut at the end
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _unmarked_utf16(head: bytes) -> str | None:
    """Return the encoding of UTF-16 without a mark, as in some exports; None for other text."""
    for encoding, high, low in (("utf-16-le", head[1::2], head[::2]), ("utf-16-be", head[::2], head[1::2])):
        if high.count(0) > 0.9 * len(high) and 0 not in low:
            return encoding
    return None


def head_text(head: bytes) -> str:
    """Return the beginning of a file as text with plain line ends, empty if it is not text; for sniffing."""
    encoding = encoding_of(head)
    if encoding is None:
        return ""
    return head.decode(encoding, "replace").lstrip("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text file without their ends, numbered from 1.

    Raises:
        FileError: If the file cannot be opened, is not text or has a line of absurd length.
    """
    with path.open("rb") as raw:
        encoding = encoding_of(raw.read(HEAD_SIZE))
    if encoding is None:
        raise FileError(path, "this is binary data where text was expected")
    with path.open(encoding=encoding, errors="replace") as file:
        number = 0
        while line := file.readline(MAX_LINE):
            number += 1
            if len(line) == MAX_LINE:
                raise FileError(path, f"the line has more than {MAX_LINE} characters", number)
            yield number, line.rstrip("\n\0\x1a")


def ends_in_mid_line(path: Path) -> bool:
    """Return whether the last line of a text file has no end, as when writing was cut off."""
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 4))
        return not file.read().rstrip(_PADDING).endswith((b"\n", b"\r"))
