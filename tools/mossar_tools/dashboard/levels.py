"""Levels: their names and numbers on the page.

A named level is that of `--level`: a strength and the bundle of features that the strengths are of. A number is a
strength within the bundle that is in force; it never borrows a name from another one.
"""

from mossar_stream import LEVEL_NAMES, LevelName, Settings


def needs_other_bundle(settings: Settings, level: LevelName | float) -> bool:
    """Return whether a level is of other features than those of the settings.

    Example:
        >>> needs_other_bundle(Settings(), "cluster"), needs_other_bundle(Settings(), 0.5)
        (True, False)
    """
    return settings.at_level(level) is not settings


def strength_of(settings: Settings, level: LevelName | float) -> float:
    """Return the strength that a level stands for within the bundle of the settings."""
    return settings.strength(level)


def highest_strength(settings: Settings) -> float:
    """Return the largest strength of a slider."""
    names = [name for name in LEVEL_NAMES if not needs_other_bundle(settings, name)]  # type: ignore[arg-type]
    return 2.0 * max([0.5, *(settings.strength(name) for name in names)])  # type: ignore[arg-type]


def level_words(settings: Settings, level: LevelName | float, strength: float, count: int | None) -> str:
    """Return the present level, in words.

    Args:
        settings: Those in force.
        level: A name or a strength.
        strength: Its strength.
        count: Wanted number of key frames instead; None for a level.

    Example:
        >>> level_words(Settings(), "motion", 0.45, None)
        'level motion: strength 0.45 and more'
    """
    if count is not None:
        return f"the {count} strongest, with the features of {settings.bundle}"
    if isinstance(level, str):
        return f"level {level}: strength {strength:.2f} and more"
    return f"strength {strength:.2f} and more, with the features of {settings.bundle}"
