"""Text files with one frame per line: counted once, then read in blocks."""

from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec

from mossar_adapters.files.cells import number
from mossar_adapters.files.columns import MAX_COLUMNS
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.text import ends_in_mid_line, numbered_lines

CHUNK = 256  # frames that a reader yields at a time


class Block(msgspec.Struct, frozen=True):
    """Consecutive rows.

    Args:
        start: Index of the first row, from 0.
        lines: Line number of each row.
        cells: The rows, all equally wide.
    """

    start: int
    lines: list[int]
    cells: list[list[str]]


class Rows(msgspec.Struct, frozen=True):
    """The whole rows of a file; a last one that was cut off is not among them.

    Args:
        path: The file.
        first_line: Number of the line from which on rows are looked for.
        split: Makes cells of a line.
        width: Cells per row.
        pad: Whether a short row is filled with empty cells instead of being an error.
        exact: Whether a long row is an error instead of being cut.
        blank: Whether a line of nothing but tabs is a row in which everything is missing.
        count: Number of whole rows.
        cut: Whether the last row of the file was not whole.
    """

    path: Path
    first_line: int
    split: Callable[[str], list[str]]
    width: int
    pad: bool
    exact: bool
    blank: bool
    count: int
    cut: bool

    def blocks(self) -> Iterator[Block]:
        """Yield the rows in blocks of `CHUNK`.

        Raises:
            FileError: If a row has the wrong width.
        """
        done, lines, cells = 0, list[int](), list[list[str]]()
        for line, text in row_lines(self.path, self.first_line, blank=self.blank):
            if done + len(cells) == self.count:
                break
            lines.append(line)
            cells.append(self._row(line, text))
            if len(cells) == CHUNK:
                yield Block(done, lines, cells)
                done, lines, cells = done + CHUNK, [], []
        if cells:
            yield Block(done, lines, cells)

    def _row(self, line: int, text: str) -> list[str]:
        row = self.split(text)
        short = self.width - len(row)
        if (short > 0 and not self.pad) or (short < 0 and self.exact):
            raise FileError(self.path, f"the row has {len(row)} values instead of {self.width}", line)
        return row[: self.width] + [""] * short


def row_lines(path: Path, first_line: int, *, blank: bool = False) -> Iterator[tuple[int, str]]:
    """Yield the lines from `first_line` on that are neither blank nor comments.

    Args:
        path: The file.
        first_line: Number of a line.
        blank: Whether to yield lines of nothing but tabs.
    """
    for line, text in numbered_lines(path):
        said = text and not text.isspace() and not text.startswith("#")
        if line >= first_line and (said or (blank and "\t" in text)):
            yield line, text


def survey(
    path: Path,
    first_line: int,
    split: Callable[[str], list[str]],
    width: int,
    *,
    pad: bool = False,
    exact: bool = False,
    blank: bool = False,
) -> Rows:
    """Count the rows of a file and see whether the last one is whole.

    Raises:
        FileError: If there is no whole row, or rows would be too wide.
    """
    if width > MAX_COLUMNS:
        raise FileError(path, f"the headings ask for {width} columns; at most {MAX_COLUMNS} can be read")
    count, last = 0, ""
    for _, text in row_lines(path, first_line, blank=blank):
        count, last = count + 1, text
    cut = count > 0 and not _is_whole(split(last), width, pad=pad, open_end=ends_in_mid_line(path))
    if count == cut:
        raise FileError(path, "there is no whole frame in the file")
    return Rows(path, first_line, split, width, pad, exact, blank, count - cut, cut)


def _is_whole(row: list[str], width: int, *, pad: bool, open_end: bool) -> bool:
    if len(row) < width:
        return pad and not open_end
    try:
        number(row[width - 1])
    except ValueError:
        return not open_end
    return True


def cut_note(rows: Rows, announced: int | None = None) -> tuple[str, ...]:
    """Return notes about missing frames.

    Args:
        rows: The rows.
        announced: Number of frames that the file states, if it does.
    """
    if announced is not None and announced > rows.count:
        return (f"the file is cut off: {rows.count} of {announced} frames are there",)
    if rows.cut:
        return (f"the file is cut off in its last frame; {rows.count} frames are whole",)
    return ()
