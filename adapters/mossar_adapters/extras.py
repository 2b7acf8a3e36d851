"""Optional libraries: found when they are needed, with an error that names how to install them here."""

import importlib.util
import os
import sys
from importlib import metadata
from pathlib import Path

from mossar_stream import MossarError

DISTRIBUTION = "mossar-stream"


def installed(library: str) -> bool:
    """Return whether a library can be imported."""
    return importlib.util.find_spec(library) is not None


def needed(library: str, extra: str, what: str) -> None:
    """Check that a library is there.

    Args:
        library: Import name.
        extra: Extra of the distribution that brings it.
        what: The feature that needs it, for the message.

    Raises:
        MossarError: If it is not installed.
    """
    if not installed(library):
        raise MossarError(f"{what} needs an extra: {install_line(extra)}")


def install_line(extra: str) -> str:
    """Return the command that installs an extra, with the program that installed mossar-stream.

    `pip install 'mossar-stream[web]'` adds the missing packages to the installed version, from wherever that came. Where
    nothing was installed, as with PYTHONPATH, it is the folder of the project that is installed.
    """
    quote = '"' if os.name == "nt" else "'"
    wanted = f"{quote}{DISTRIBUTION}[{extra}]{quote}"
    try:
        installer = (metadata.distribution(DISTRIBUTION).read_text("INSTALLER") or "pip").strip()
    except metadata.PackageNotFoundError:
        project = Path(__file__).parents[2]
        return (
            f"pip install {quote}{project}[{extra}]{quote}"
            if _is_project(project)
            else f"pip install {wanted}"
        )
    if "pipx" in Path(sys.prefix).parts:
        return f"pipx inject {DISTRIBUTION} {wanted}"
    return f"{'uv pip' if installer == 'uv' else 'pip'} install {wanted}"


def _is_project(folder: Path) -> bool:
    return (folder / "pyproject.toml").exists()
