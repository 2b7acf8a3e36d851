"""Settings as a TOML file that `--config` reads."""

import json

import msgspec

from mossar_stream import LevelName, Settings


def as_toml(settings: Settings, level: LevelName | float, strength: float) -> str:
    """Return settings as TOML.

    All values of the level's bundle are written out, so that the file does not depend on other settings. A range of a
    whole recording is left out, because streams have none.

    Args:
        settings: The present settings, with `level` as it was at the start.
        level: The present level.
        strength: The strength of `level`.

    Example:
        >>> print(as_toml(Settings(), "motion", 0.45).splitlines()[1])
        level = "motion"
    """
    # A name is kept only with its own bundle; a strength that was chosen by hand is kept as a number.
    kept = level if level == settings.level else float(f"{strength:.6g}")
    values = msgspec.to_builtins(settings.resolved())
    if settings.range == "file":
        values.pop("range")
    values.pop("level")
    tables = {name: value for name, value in values.items() if isinstance(value, dict)}
    lines = ["# Settings of mossar; use with --config", f"level = {json.dumps(kept)}", "", "[settings]"]
    lines += [f"{n} = {json.dumps(v)}" for n, v in values.items() if n not in tables and v is not None]
    for name, table in tables.items():
        lines += ["", f"[settings.{name}]", *(f"{part} = {json.dumps(v)}" for part, v in table.items())]
    return "\n".join(lines) + "\n"
