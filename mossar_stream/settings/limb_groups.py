"""The text by which users name the joints of limbs."""

import re

from mossar_stream.errors import SettingsError
from mossar_stream.events import BODY

MOST_LIMBS = 16  # of a skeleton
# Words at the place of a channel in the ids of other events.
RESERVED = (
    BODY,
    "move",
    "activity",
    "step",
)
_NAME = re.compile(r"[A-Za-z0-9_-]{1,32}")


def parse_groups(text: str) -> dict[str, tuple[str, ...]]:
    """Return the names of limbs and of their joints that a text gives.

    Args:
        text: `left_arm=LeftElbow,LeftHand;tail=TailMiddle,TailTip`.

    Raises:
        SettingsError: If it is not of that form.

    Example:
        >>> parse_groups("tail=TailMiddle,TailTip")
        {'tail': ('TailMiddle', 'TailTip')}
    """
    groups: dict[str, tuple[str, ...]] = {}
    for part in text.split(";"):
        name, _, joints = (word.strip() for word in part.partition("="))
        members = tuple(joint.strip() for joint in joints.split(","))
        if not _NAME.fullmatch(name) or name in RESERVED or name in groups or not all(members):
            raise SettingsError(
                f"setting limbs is {text[:80]!r}; it must be true, false, or names and joints as in "
                "left_arm=LeftElbow,LeftHand;tail=TailTip (letters, digits, _ and - in names, each name once; not "
                f"{', '.join(RESERVED)})"
            )
        groups[name] = members
    if len(groups) > MOST_LIMBS:
        raise SettingsError(f"setting limbs has {len(groups)} limbs; there may be {MOST_LIMBS}")
    return groups
