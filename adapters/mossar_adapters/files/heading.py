"""The begin of the rows of a table, and the lines above them.

The headings may be one line (`hip.x,hip.y,hip.z`) or two, names above axes, as programs of optical systems and
data frames with two levels write them; then a line of units may follow::

    ,,anna:LFHD,,,anna:RFHD,,
    Frame,Sub Frame,X,Y,Z,X,Y,Z
    ,,mm,mm,mm,mm,mm,mm
"""

import csv
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import msgspec

from mossar_adapters.files.columns import MAX_COLUMNS, MAX_HEADING, Columns, find_columns
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import metres_of

MAX_LINES = 50  # above the rows


class Heading(msgspec.Struct, frozen=True):
    """The lines above the rows.

    Args:
        metadata: Words `key=value` of comment lines; `unit` also from a line of units, `fps` also from a line that
            is a number and nothing else.
        columns: By the headings.
        first_line: Number of the first line after the headings.
        split: Makes cells of a line.
        width: Cells that a row must have.
    """

    metadata: dict[str, str]
    columns: Columns
    first_line: int
    split: Callable[[str], list[str]]
    width: int


def read_heading(path: Path) -> Heading:
    """Read up to the first row.

    Raises:
        FileError: If there are no headings of joints.
    """
    metadata: dict[str, str] = {}
    above: list[str] = []
    lines = numbered_lines(path)
    for line, text in lines:
        if line > MAX_LINES:
            break
        if text.startswith("#"):
            metadata.update(word.partition("=")[::2] for word in text[1:].split() if "=" in word)
            continue
        delimiter = delimiter_of(text)
        cells = splitter(delimiter)(text)
        columns = find_columns(cells) or find_columns(_two_lines(above, cells))
        if columns:
            return _heading(metadata, columns, line, delimiter, lines)
        lone = text.strip(" \t;,")
        if lone.replace(".", "", 1).isdecimal():
            metadata.setdefault("fps", lone)
        above = cells
    raise FileError(path, "no headings with x, y and z of joints, such as: time,hips.x,hips.y,hips.z")


def splitter(delimiter: str | None, *, decimal_comma: bool = False) -> Callable[[str], list[str]]:
    """Return a function that makes cells of a line.

    Args:
        delimiter: One character, or None for any white space.
        decimal_comma: Whether numbers are written `0,5`.
    """

    def split(text: str) -> list[str]:
        if decimal_comma:
            text = text.replace(",", ".")
        if delimiter and '"' in text:
            return quoted_cells(text, delimiter)
        return text.split(delimiter)

    return split


def quoted_cells(text: str, delimiter: str) -> list[str]:
    """Return the cells of a line in which some may stand in quotes."""
    try:
        return next(csv.reader([text], delimiter=delimiter), [])
    except csv.Error:  # a quote without end, for instance
        return text.split(delimiter)


def delimiter_of(header: str) -> str | None:
    """Return the separator of headings: the most frequent of tab, semicolon and comma, else white space."""
    best = max("\t;,", key=header.count)
    return best if best in header else None


def _heading(
    metadata: dict[str, str],
    columns: Columns,
    line: int,
    delimiter: str | None,
    lines: Iterator[tuple[int, str]],
) -> Heading:
    """Return the heading, after a look at the line behind the names."""
    sample_line, sample = next(((n, text) for n, text in lines if text.strip()), (line, ""))
    units = {cell.strip().lower() for cell in splitter(delimiter)(sample)} - {""}
    if len(units) == 1 and metres_of(*units) is not None:
        metadata.setdefault("unit", units.pop())
        line = sample_line
        sample = next((text for _, text in lines if text.strip()), "")
    decimal_comma = delimiter != "," and "," in sample and "." not in sample
    last = max(columns.time, columns.body, *columns.confidence, *(c for xyz in columns.xyz for c in xyz))
    return Heading(metadata, columns, line + 1, splitter(delimiter, decimal_comma=decimal_comma), last + 1)


def _two_lines(names: Sequence[str], axes: Sequence[str]) -> list[str]:
    """Return headings put together of a line of names, blank where a name goes on, and one of axes."""
    plain = [cell.strip().lower() for cell in axes]
    if len(axes) > MAX_COLUMNS or sum(cell in {"x", "y", "z"} for cell in plain) < 3:
        return []
    headings, name = [], ""
    for i, axis in enumerate(axes):
        name = (names[i].strip()[:MAX_HEADING] if i < len(names) else "") or name
        headings.append(f"{name}.{axis.strip()}" if plain[i] in {"x", "y", "z"} and name else axis)
    return headings
