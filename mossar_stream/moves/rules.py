"""Rules: settings of each move in a file of moves, and the way that performers face."""

from typing import Annotated, Any, Literal

import msgspec

from mossar_stream.errors import MovesError

Facing = Literal["any", "as_shown"]
FACINGS: tuple[Facing, ...] = ("any", "as_shown")
MOST_AGAIN = 3600.0  # s


class MoveRule(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The rule by which one move is recognised.

    Args:
        strict: From 0 (the nearest move) to 1 (almost identical movements only).
        again: s after the move was confirmed during which it is not confirmed again.
        mirrored: Whether the mirror image is the move as well. A name with "left" or "right" in it is that of the side
            that was shown; the mirror image then has the name of the other side.
    """

    strict: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.5
    again: Annotated[float, msgspec.Meta(ge=0, le=MOST_AGAIN)] = 0.0
    mirrored: bool = False


USUAL, MIRRORED = MoveRule(), MoveRule(mirrored=True)  # a pose has one of these


def changed_rule(
    rule: MoveRule, strict: float | None, again: float | None, mirrored: bool | None
) -> MoveRule:
    """Return a rule with other values; None keeps a value.

    Raises:
        MovesError: If a value is out of range or of the wrong kind.
    """
    given = {"strict": strict, "again": again, "mirrored": mirrored}
    fields = {name: value for name, value in given.items() if value is not None}
    for name, most in (("strict", 1.0), ("again", MOST_AGAIN)):
        value: Any = fields.get(name, 0.0)  # of any type, from a file or a program
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= most:
            raise MovesError(f"{name} is a number from 0 to {most:g}, not {value!r}")
    if not isinstance(fields.get("mirrored", False), bool):
        raise MovesError(f"mirrored is True or False, not {mirrored!r}")
    return msgspec.structs.replace(rule, **fields)


def check_facing(facing: str) -> Facing:
    """Return a way of facing if it is one.

    Raises:
        MovesError: If it is not.
    """
    for known in FACINGS:
        if facing == known:
            return known
    raise MovesError(f"facing is one of {', '.join(FACINGS)}, not {str(facing)[:40]!r}")
