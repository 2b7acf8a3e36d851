"""TRC: markers in text; tabs, commas, semicolons or spaces; blank cells are missing."""

from pathlib import Path

from mossar_adapters.files.cells import positive
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.heading import delimiter_of, splitter
from mossar_adapters.files.marker_table import MarkerTable, read_markers
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rows import cut_note, survey
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import metres_of
from mossar_adapters.source import Recording

_HEAD = 40  # lines within which the heading ends


def read(path: Path, options: ReadOptions) -> Recording:
    """Read markers."""
    metadata, header, line = _heading(path)
    delimiter = "\t" if "\t" in header else delimiter_of(header)
    split = splitter(delimiter, decimal_comma=delimiter == ";")
    labels, xyz = _markers(split(header))
    if not labels:
        raise FileError(path, "there are no marker names", line)
    rows = survey(path, _first_row(path, line), split, xyz[-1] + 3, pad=True)
    announced = positive(metadata.get("numframes"))
    return read_markers(
        MarkerTable(
            rows=rows,
            labels=labels,
            xyz=xyz,
            fps=positive(metadata.get("datarate")),
            metres=metres_of(metadata.get("units", "")),
            time=1,
            frame=0,
            first_number=1,
            notes=cut_note(rows, None if announced is None else int(announced)),
        ),
        options,
    )


def _heading(path: Path) -> tuple[dict[str, str], str, int]:
    """Return the metadata of the second and third line, the line of marker names, and its number."""
    metadata: dict[str, str] = {}
    previous: list[str] = []
    for line, text in numbered_lines(path):
        text = text.replace('"', "")
        cells = (text if "\t" in text else text.replace(",", "\t").replace(";", "\t")).split()
        if cells and cells[0].lower().rstrip("#") == "frame":
            return metadata, text, line
        if previous and previous[0].lower() == "datarate":
            metadata = dict(zip((word.lower() for word in previous), cells, strict=False))
        previous = cells
        if line > _HEAD:
            break
    raise FileError(path, f"there is no line of marker names that begins with {shown('Frame#')}")


def _markers(header: list[str]) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return the names of the markers and the columns of their x.

    A name stands above its x, so that a marker without one leaves a gap; some programs write them in a row.
    """
    found = {i: cell.strip() for i, cell in enumerate(header) if i >= 2 and cell.strip()}
    above = all(i % 3 == 2 for i in found) and len(found) > 1
    return tuple(found.values()), tuple(found) if above else tuple(range(2, 2 + 3 * len(found), 3))


def _first_row(path: Path, names: int) -> int:
    """Return the line at which rows may begin: after that of X1 Y1 Z1 and one of nothing but delimiters."""
    axes = names + 1
    following = next((text for line, text in numbered_lines(path) if line == axes + 1), "")
    return axes + 1 if following.strip(" \t,;") else axes + 2
