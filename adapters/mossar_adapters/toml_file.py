"""TOML files of people: configurations and jobs."""

import tomllib
from pathlib import Path
from typing import Any

from mossar_adapters.regular import check_regular
from mossar_stream import MossarError

MAX_BYTES = 1 << 20
_LARGEST = 1 << 63  # limit that TOML asks every reader to support; larger numbers cannot even be shown


def read_toml(path: Path, kind: str, error: type[MossarError]) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        path: The file.
        kind: Its purpose, for messages.
        error: The exception to raise, with one line about the problem.
    """
    try:
        check_regular(path)
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise error(f"{path}: larger than 1 MB; this is no {kind}")
        content = tomllib.loads(data.decode())
        _check(content)
    except OSError as failure:
        raise error(f"{path}: cannot be read: {failure.strerror or failure}") from None
    except (ValueError, RecursionError) as failure:
        # Kinds of ValueError: TOMLDecodeError, UnicodeError, thousands of digits.
        raise error(f"{path}: not valid TOML: {failure}") from None
    return content


def _check(value: Any) -> None:
    """Refuse values of TOML that no option can have: they would surface as other errors."""
    if isinstance(value, dict):
        for key, part in value.items():
            _check(key)
            _check(part)
    elif isinstance(value, list):
        for part in value:
            _check(part)
    elif isinstance(value, str) and "\0" in value:
        raise ValueError(f"there is a NUL character in {value[:40]!r}")
    elif isinstance(value, int) and not -_LARGEST <= value < _LARGEST:
        raise ValueError("there is an integer of more than 64 bits")
