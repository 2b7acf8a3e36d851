"""The text by which users name the joints of the feet."""

import re

from mossar_stream.errors import SettingsError
from mossar_stream.events import Side

SIDES: tuple[Side, Side] = ("left", "right")
MOST_POINTS = 4  # of a foot
_SHAPE = re.compile(r"\s*(left|right)\s*=\s*(.+)")


def parse_feet(text: str) -> dict[str, tuple[str, ...]]:
    """Return the joints of each foot that a text names.

    Args:
        text: `left=A,B right=C,D`; a semicolon may part them, too.

    Raises:
        SettingsError: If it is not of that form.

    Example:
        >>> parse_feet("left=LANK,LTOE right=RANK,RTOE")["right"]
        ('RANK', 'RTOE')
    """
    found: dict[str, tuple[str, ...]] = {}
    for part in re.split(r";|\s+(?=right\s*=|left\s*=)", text.strip()):
        match = _SHAPE.fullmatch(part)
        names = tuple(name.strip() for name in match[2].split(",")) if match else ()
        if match is None or match[1] in found or not all(names) or len(names) > MOST_POINTS:
            raise SettingsError(
                f"setting feet is {text[:80]!r}; it must name one to {MOST_POINTS} joints of each foot, as in "
                "left=LANK,LTOE right=RANK,RTOE"
            )
        found[match[1]] = names
    if set(found) != set(SIDES):
        raise SettingsError(
            f"setting feet is {text[:80]!r}; it must name joints of the left and of the right foot"
        )
    return found
