"""Sessions: columns with person and session of a recording, so that one table holds a whole study."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from mossar_adapters.segment_csv import COLUMNS
from mossar_tools.errors import UsageError

if TYPE_CHECKING:
    from mossar_tools.commands.segment import Options

_FIELD = re.compile(r"\{(\w+)\}")


def columns_of_names(options: "Options") -> tuple[str, ...]:
    """Return the columns that `--person`, `--session` and `--pattern` add, in this order."""
    given = [name for name in ("person", "session") if getattr(options, name) is not None]
    return (*given, *(name for name in _FIELD.findall(options.pattern or "") if name not in given))


def values_of_name(options: "Options", path: str) -> dict[str, str]:
    """Return the values of these columns for a recording; options take precedence over the file's name.

    Args:
        options: The user's options.
        path: Of the recording.

    Raises:
        UsageError: If the pattern does not fit the file's name.
    """
    given = {name: value for name in ("person", "session") if (value := getattr(options, name)) is not None}
    if options.pattern is None:
        return given
    parts = options.pattern.count("/") + 1
    name = "/".join(Path(path).with_suffix("").parts[-parts:])
    match = _expression(options.pattern).fullmatch(name)
    if match is None:
        raise UsageError(f"{path}: its name does not fit --pattern {options.pattern}")
    return {**match.groupdict(), **given}


def check_pattern(options: "Options") -> None:
    """Refuse a pattern without names, or with a name twice.

    Raises:
        UsageError: If it has no field, a field twice, or one that is a column already.
    """
    if options.pattern is None:
        return
    fields = _FIELD.findall(options.pattern)
    taken = next((name for name in fields if name in COLUMNS or not name.isidentifier()), None)
    if not fields or len(set(fields)) < len(fields):
        raise UsageError(
            f"--pattern {options.pattern}: name each column once, as in {{person}}_{{session}}_{{trial}}"
        )
    if taken is not None:
        raise UsageError(f"--pattern {options.pattern}: {taken} is a column already, or no name for one")


def _expression(pattern: str) -> re.Pattern[str]:
    """Return the pattern as an expression: a field is as short as it can be, but for the last, and has no slash."""
    pieces = _FIELD.split(pattern)
    text = "".join(f"(?P<{piece}>[^/]+?)" if i % 2 else re.escape(piece) for i, piece in enumerate(pieces))
    return re.compile(text)
