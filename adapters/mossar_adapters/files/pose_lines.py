"""Pose JSON with a frame per line, read line by line: such files may be of any length."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines
from mossar_adapters.maps.json_nan import without_nan

_DAMAGE = (ValueError, RecursionError)


class PoseLines(msgspec.Struct):
    """The frames of a file.

    Args:
        path: The file.
        cut: Whether the last line was cut off; known when all were read.
    """

    path: Path
    cut: bool = False

    def __iter__(self) -> Iterator[Any]:
        """Yield the content of each line.

        Raises:
            FileError: If a line is no JSON.
        """
        broken: FileError | None = None
        for line, text in _lines(self.path):
            if broken is not None:
                raise broken
            try:
                found = _decoded(text)
            except _DAMAGE as error:
                broken = FileError(self.path, f"this is no JSON: {error}", line)
            else:
                yield found
        if broken is not None and not ends_in_mid_line(self.path):
            raise broken
        self.cut = broken is not None


def has_frame_per_line(path: Path) -> bool:
    """Return whether there are several lines, the first of which is JSON by itself and the next begins alike."""
    try:
        first, second = (text for _, text in islice(_lines(path), 2))
        _decoded(first)
    except (FileError, *_DAMAGE):
        return False
    return first.lstrip()[:1] == second.lstrip()[:1]


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    return ((line, text) for line, text in numbered_lines(path) if text and not text.isspace())


def _decoded(text: str) -> Any:
    """Return the content of JSON; NaN, as Python writes it, is null."""
    try:
        return msgspec.json.decode(text)
    except _DAMAGE:
        plain = without_nan(text.encode())
        if plain is None:
            raise
        return msgspec.json.decode(plain)
