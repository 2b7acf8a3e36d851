"""Text of tables: comma-separated lines whose cells no spreadsheet takes for formulas.

Names of performers, joints, moves and files come from networks and from others' files. A cell that would begin a formula is
written with an apostrophe before it, and read back without. Numbers stay as they are.
"""

import csv
import io
import re
from collections.abc import Iterable

# Wide signs too, as Japanese spreadsheets read them.
_FORMULA = re.compile(r"'*(?:\s*[=+\-@\uff1d\uff0b\uff0d\uff20]|[\t\r\n])")
_NUMBER = re.compile(r"[+-]?(?:inf|nan|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)", re.ASCII)


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return lines of a table, each cell guarded.

    Example:
        >>> csv_text([["performer", "x"], ["=1+1", -2.5], ["p1", "-2.5000"]]).splitlines()
        ['performer,x', "'=1+1,-2.5", 'p1,-2.5000']
    """
    text = io.StringIO()
    guarded = ([cell(value) if isinstance(value, str) else value for value in row] for row in rows)
    csv.writer(text, lineterminator="\n").writerows(guarded)
    return text.getvalue()


def cell(text: str) -> str:
    """Return a text as a cell that is no formula; `without_guard` returns the text again."""
    return f"'{text}" if _FORMULA.match(text) and not _NUMBER.fullmatch(text) else text


def without_guard(text: str) -> str:
    """Return the text of a cell that `cell` wrote."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text
