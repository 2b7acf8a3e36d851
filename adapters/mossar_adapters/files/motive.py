"""Motive: CSV of OptiTrack's program; bones of a skeleton, else labelled markers, else rigid bodies."""

from itertools import pairwise
from pathlib import Path

import msgspec

from mossar_adapters.files.cells import positive
from mossar_adapters.files.errors import FileError
from mossar_adapters.files.heading import delimiter_of, quoted_cells, splitter
from mossar_adapters.files.marker_table import MarkerTable, read_markers
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rows import cut_note, survey
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.files.units import metres_of
from mossar_adapters.source import Recording

_PREFERRED = ("bone", "marker", "rigid body", "bone marker", "rigid body marker")
_HEAD = 30  # lines within which the heading ends


class Heading(msgspec.Struct):
    """The lines above the rows.

    Args:
        metadata: Pairs of the first line, keys in lower case.
        kinds: `Bone`, `Marker` … of each column.
        names: Of each column.
        parents: Of each column, empty in older versions.
        quantities: `Rotation`, `Position` … of each column.
        axes: `X`, `Y`, `Z`, `W` of each column.
        line: Number of the line with the axes.
        delimiter: A comma; a semicolon or a tab where a spreadsheet has saved the file again.
    """

    metadata: dict[str, str]
    kinds: list[str] = msgspec.field(default_factory=list)
    names: list[str] = msgspec.field(default_factory=list)
    parents: list[str] = msgspec.field(default_factory=list)
    quantities: list[str] = msgspec.field(default_factory=list)
    axes: list[str] = msgspec.field(default_factory=list)
    line: int = 0
    delimiter: str = ","


def read(path: Path, options: ReadOptions) -> Recording:
    """Read bones or markers."""
    heading = _heading(path)
    columns = _positions(heading)
    if not columns:
        raise FileError(path, "there are no columns of positions", heading.line)
    if (
        heading.metadata.get("coordinate space", "").lower() == "local"
        and _kind(heading, columns[0]) == "bone"
    ):
        raise FileError(path, "its bones are relative to their parents; export them in global coordinates")
    split = splitter(heading.delimiter, decimal_comma=heading.delimiter != ",")
    rows = survey(path, heading.line + 1, split, max(columns) + 3, pad=True)
    announced = positive(heading.metadata.get("total exported frames"))
    parents = None
    if heading.parents:
        parents = [_label(heading.parents[column]) for column in columns]
    return read_markers(
        MarkerTable(
            rows=rows,
            labels=tuple(_label(heading.names[column]) for column in columns),
            xyz=tuple(columns),
            fps=positive(heading.metadata.get("export frame rate"))
            or positive(heading.metadata.get("capture frame rate")),
            metres=metres_of(heading.metadata.get("length units", "")),
            time=1,
            frame=0,
            parents=parents,
            notes=cut_note(rows, None if announced is None else int(announced)),
        ),
        options,
    )


def _heading(path: Path) -> Heading:
    heading = Heading({})
    unlabelled: list[list[str]] = []
    for line, text in numbered_lines(path):
        if not heading.metadata:
            heading.delimiter = delimiter_of(text) or ","
        cells = [cell.strip() for cell in quoted_cells(text, heading.delimiter)]
        if not heading.metadata:
            heading.metadata = {key.lower(): value for key, value in pairwise(cells)}  # takes may have commas
        elif cells and cells[0].lower() == "frame":
            heading.axes, heading.line = cells, line
            break
        elif "Position" in cells:
            heading.quantities = cells
        elif any(cells):
            match (cells[0] or cells[1]).lower() if len(cells) > 1 else "":
                case "type":
                    heading.kinds = cells
                case "name":
                    heading.names = cells
                case "parent":
                    heading.parents = cells
                case "":
                    unlabelled.append(cells)
        if line > _HEAD:
            break
    if unlabelled and not heading.kinds:
        heading.kinds, heading.names = (*unlabelled, [], [])[:2]
    if not (heading.axes and heading.kinds and heading.names and heading.quantities):
        raise FileError(path, "the heading lacks the lines of types, names, positions or axes")
    for cells in (heading.kinds, heading.names, heading.quantities, heading.parents):
        if cells:
            cells += [""] * (len(heading.axes) - len(cells))
    return heading


def _positions(heading: Heading) -> list[int]:
    """Return the x column of each thing of the preferred kind."""
    starts = [
        i
        for i in range(2, len(heading.axes) - 2)
        if [axis.upper() for axis in heading.axes[i : i + 3]] == ["X", "Y", "Z"]
        and heading.quantities[i : i + 3] == ["Position"] * 3
    ]
    starts = [i for i in starts if not heading.names[i].lower().startswith("unlabeled")] or starts
    for kind in _PREFERRED:
        found = [i for i in starts if _kind(heading, i) == kind]
        if found:
            return found
    return starts


def _kind(heading: Heading, column: int) -> str:
    return heading.kinds[column].lower()


def _label(name: str) -> str:
    """Return a name; the first bone is called after its skeleton, `anna:anna`, and is the hip."""
    subject, colon, bone = name.rpartition(":")
    return f"{subject}:Hip" if colon and subject == bone else name
