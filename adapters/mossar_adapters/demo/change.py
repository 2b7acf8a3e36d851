"""Change: from the posture of one move to that of the next, in one brisk movement."""

import math
from typing import Final

from mossar_adapters.demo.body import CHANNELS, Floats
from mossar_adapters.demo.postures import limb
from mossar_adapters.demo.script import Script

_STEP_LIFT: Final = 0.05  # m
_STEP_SHARE: Final = 0.6  # of the change, for each of two feet that move in turn
_ASIDE: Final = 0.01  # m from which on a foot has to be lifted
_IN_THE_AIR: Final = 0.1  # m


def change(script: Script, goal: Floats, seconds: float) -> None:
    """Write the change from the script's posture to `goal` (C,), over `seconds` from its start.

    Feet that move are lifted; where both do, the one in the air comes down before the other goes up.
    """
    before, after = script.posture, dict(zip(CHANNELS, goal.tolist(), strict=True))
    feet = {side: [f"{side}_{name}" for name in ("x", "y", "z", "yaw", "pitch")] for side in "lr"}
    trunk_and_arms = set(CHANNELS).difference(*feet.values())
    script.to(0.0, seconds, **{name: after[name] for name in CHANNELS if name in trunk_and_arms})
    moving = [side for side in "lr" if _distance(before, after, side) > _ASIDE]
    moving.sort(key=lambda side: before[f"{side}_y"], reverse=True)
    for side, names in feet.items():
        start, end = 0.0, seconds
        if len(moving) > 1:
            first = side == moving[0]
            start, end = (0.0, _STEP_SHARE * seconds) if first else ((1.0 - _STEP_SHARE) * seconds, seconds)
        script.to(start, end, **{name: after[name] for name in names})
        if side in moving and max(before[f"{side}_y"], after[f"{side}_y"]) < _IN_THE_AIR:
            script.sway(start, end, **limb(side, y=_STEP_LIFT))


def _distance(before: dict[str, float], after: dict[str, float], side: str) -> float:
    """Return the distance that a foot moves, m."""
    names = [f"{side}_{axis}" for axis in "xyz"]
    return math.dist([before[name] for name in names], [after[name] for name in names])
