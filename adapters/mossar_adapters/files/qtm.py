"""QTM: Qualisys tab-separated values of 3-D markers, in millimetres; zeros are missing."""

from pathlib import Path

from mossar_adapters.files.cells import is_number, positive
from mossar_adapters.files.errors import FileError, shown
from mossar_adapters.files.heading import splitter
from mossar_adapters.files.marker_table import MarkerTable, read_markers
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.files.rows import cut_note, survey
from mossar_adapters.files.text import numbered_lines
from mossar_adapters.source import Recording

_HEAD = 100  # lines within which the heading ends


def read(path: Path, options: ReadOptions) -> Recording:
    """Read markers."""
    metadata, width, line = _heading(path)
    included = metadata.get("DATA_INCLUDED", ["3D"])[0].upper()
    if included != "3D":
        raise FileError(path, f"it holds {shown(included)} data; only 3D markers can be read")
    labels = tuple(name for name in metadata.get("MARKER_NAMES", []) if name)
    if not labels:
        raise FileError(path, "there are no MARKER_NAMES")
    # Frame and time stand in front, with headings or without.
    first = 2 if "FRAME" in metadata or width >= 3 * len(labels) + 2 else 0
    rows = survey(path, line, splitter("\t"), first + 3 * len(labels), pad=True, blank=True)
    announced = positive(metadata.get("NO_OF_FRAMES", [""])[0])
    return read_markers(
        MarkerTable(
            rows=rows,
            labels=labels,
            xyz=tuple(range(first, first + 3 * len(labels), 3)),
            fps=positive(metadata.get("FREQUENCY", [""])[0]),
            metres=1e-3,
            time=1 if first else -1,
            frame=0 if first else -1,
            first_number=1,
            notes=cut_note(rows, None if announced is None else int(announced)),
        ),
        options,
    )


def _heading(path: Path) -> tuple[dict[str, list[str]], int, int]:
    """Return the metadata, the width of the first row, and the number of its line."""
    metadata: dict[str, list[str]] = {}
    for line, text in numbered_lines(path):
        cells = text.split("\t")
        if len(cells) > 1 and is_number(cells[0]):
            return metadata, len(cells), line
        if len(cells) > 1:
            metadata[cells[0].strip().upper()] = [cell.strip() for cell in cells[1:]]
        if line > _HEAD:
            break
    raise FileError(path, "there is no row of numbers after the heading")
