"""Tables in which several people take turns: a row per frame and person, and a column that says whose it is."""

from collections.abc import Iterator

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.rows import Block, Rows
from mossar_stream.frames import performer_name

MOST = 64  # people; with more the column means something else


def bodies_of(rows: Rows, column: int) -> dict[str, tuple[str, int]]:
    """Return performer and number of rows of each person, in the order in which they appear.

    Numbers become `p1`, `p2` … in that order; rows without a name are nobody's.

    Args:
        rows: The table.
        column: The one that says whose a row is, -1 without.

    Returns:
        By what stands in the column; empty if there is only one person.

    Raises:
        FileError: If there are too many.
    """
    counts: dict[str, int] = {}
    for block in rows.blocks() if column >= 0 else ():
        for row in block.cells:
            body = row[column].strip()
            counts[body] = counts.get(body, 0) + 1
        if len(counts) > MOST:
            raise FileError(rows.path, f"there are more than {MOST} people in column {column + 1}")
    counts.pop("", None)
    if len(counts) < 2:
        return {}
    return {
        body: (f"p{i + 1}" if body.lstrip("-").isdecimal() else performer_name(body), count)
        for i, (body, count) in enumerate(counts.items())
    }


def by_body(blocks: Iterator[Block], column: int) -> Iterator[tuple[str, Block]]:
    """Yield the rows of each person, numbered for each, and what stands in the column."""
    done: dict[str, int] = {}
    for block in blocks:
        found: dict[str, Block] = {}
        for line, row in zip(block.lines, block.cells, strict=True):
            body = row[column].strip()
            part = found.setdefault(body, Block(done.get(body, 0), [], []))
            part.lines.append(line)
            part.cells.append(row)
        for body, part in found.items():
            done[body] = part.start + len(part.lines)
            yield body, part
