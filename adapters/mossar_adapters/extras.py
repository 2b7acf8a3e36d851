"""Optional libraries: found when they are needed, with an error that names the extra to install."""

import importlib.util

from mossar_stream import MossarError


def installed(library: str) -> bool:
    """Return whether a library can be imported."""
    return importlib.util.find_spec(library) is not None


def needed(library: str, extra: str, what: str) -> None:
    """Check that a library is there.

    Args:
        library: Import name.
        extra: Extra of the distribution that brings it.
        what: What needs it, for the message.

    Raises:
        MossarError: If it is not installed.
    """
    if not installed(library):
        raise MossarError(f"{what} needs an extra: pip install 'mossar-stream[{extra}]'")
