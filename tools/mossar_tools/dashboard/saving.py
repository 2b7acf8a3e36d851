"""Saving: the settings that the page shows, in a new file."""

from pathlib import Path

from mossar_stream import LevelName, MossarError, Settings
from mossar_tools.dashboard.recorder import unused
from mossar_tools.settings_file import as_toml


def save_settings(folder: Path, settings: Settings, level: LevelName | float, strength: float) -> Path:
    """Write settings into a new file and return its path.

    Args:
        folder: Target folder.
        settings: The present ones, with the level of the start.
        level: As it is now.
        strength: The strength of `level`.

    Raises:
        MossarError: If it cannot be written.
    """
    path = unused(folder, "mossar", ".toml")
    try:
        path.write_text(as_toml(settings, level, strength), encoding="utf-8")
    except OSError as error:
        raise MossarError(f"{path}: cannot be written: {error.strerror or error}") from None
    return path
