"""Tables in which several people take turns: a row per frame and person, and a column with the person."""

import re
from collections.abc import Iterator

from mossar_adapters.files.errors import FileError
from mossar_adapters.files.rows import Block, Rows
from mossar_stream import performer_name

MOST = 64  # people
_NUMBER = re.compile(r"-?\d+(?:\.0*)?")  # some programs write whole numbers as 1.0


def bodies_of(rows: Rows, column: int) -> dict[str, tuple[str, int]]:
    """Return performer and number of rows of each person, in the order in which they appear.

    Numbers become `p1`, `p2` … in that order; rows without a name belong to no performer. A column with too many names
    that never come back is a running number, or one person whom a tracker found anew again and again.

    Args:
        rows: The table.
        column: The column of the person, -1 without.

    Returns:
        By cell of the column; empty if there is only one person.

    Raises:
        FileError: If too many people take turns.
    """
    counts: dict[str, int] = {}
    latest, turns = "", False
    for block in rows.blocks() if column >= 0 else ():
        for row in block.cells:
            body = row[column].strip()
            turns |= body in counts and body != latest
            counts[body] = counts.get(body, 0) + 1
            latest = body
        if len(counts) > MOST and not turns:
            return {}
        if len(counts) > MOST:
            raise FileError(rows.path, f"more than {MOST} people take turns in it (column {column + 1})")
    counts.pop("", None)
    if len(counts) < 2:
        return {}
    return dict(zip(counts, zip(_names(list(counts)), counts.values(), strict=True), strict=True))


def _names(bodies: list[str]) -> list[str]:
    """Return a performer's name for each, none twice."""
    numbers = [f"p{i + 1}" for i in range(len(bodies))]
    names = [
        number if _NUMBER.fullmatch(body) else performer_name(body)
        for number, body in zip(numbers, bodies, strict=True)
    ]
    return names if len(set(names)) == len(names) else numbers


def by_body(blocks: Iterator[Block], column: int) -> Iterator[tuple[str, Block]]:
    """Yield the rows of each person, numbered for each, and the cell of the column."""
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
