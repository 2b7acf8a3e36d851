"""TOML files of people: configurations and jobs."""

import tomllib
from pathlib import Path
from typing import Any

from mossar_stream import MossarError

MAX_BYTES = 1 << 20


def read_toml(path: Path, kind: str, error: type[MossarError]) -> dict[str, Any]:
    """Return what is in a file.

    Args:
        path: The file.
        kind: What it ought to be, for messages.
        error: What to raise; one line says what is wrong.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise error(f"{path}: larger than 1 MB; this is no {kind}")
        return tomllib.loads(data.decode())
    except OSError as failure:
        raise error(f"{path}: cannot be read: {failure.strerror or failure}") from None
    except (tomllib.TOMLDecodeError, UnicodeError, RecursionError) as failure:
        raise error(f"{path}: not valid TOML: {failure}") from None
