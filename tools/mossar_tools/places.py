"""Places: the options of commands that name inputs, and those that name outputs.

The rule itself is `mossar_adapters.files.replacing.check_places`; every command passes here before it begins.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from mossar_adapters.files.replacing import check_places
from mossar_tools.declared import values_of
from mossar_tools.options import STANDARD_OUTPUT

READ = ("sources", "file", "moves", "labels", "skeleton", "config", "model")
WRITTEN = ("json", "csv", "plot", "curves", "export", "save", "cut", "to", "snapshot")
# Outputs that other commands read. `teach` changes its file of moves.
WRITTEN_BY = {"record": ("file",), "teach": ("file",)}


def check_command(command: str, options: msgspec.Struct) -> None:
    """Refuse outputs of a command that are its inputs, or each other.

    Args:
        command: Its name.
        options: Of it.

    Raises:
        FileError: If there is one.
    """
    own = WRITTEN_BY.get(command, ())
    given = values_of(options)
    read = _texts(given, (name for name in READ if name not in own))
    written = _texts(given, (*WRITTEN, *own))
    if given.get("cut") is not None:
        from mossar_adapters.files.clips import TABLE

        written.append(str(Path(given["cut"], TABLE)))
    if given.get("json") == given.get("csv") == STANDARD_OUTPUT:
        written.remove(STANDARD_OUTPUT)  # which `Outputs` explains
    check_places(read, written)


def _texts(given: Mapping[str, Any], names: Iterable[str]) -> list[str]:
    """Return the values of options, each text of those that may be repeated."""
    found: list[str] = []
    for name in names:
        value = given.get(name)
        found += [value] if isinstance(value, str) else list(value or ())
    return [value for value in found if value]
