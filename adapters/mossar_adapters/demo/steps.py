"""The moves that go somewhere: walk and turn. See `moves` for the conventions."""

import math

from mossar_adapters.demo.body import NEUTRAL
from mossar_adapters.demo.postures import OTHER, SIGN, limb
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import cruise, shaking

STEP_TIME = 0.50  # s
STEP_LENGTH = 0.60  # m
PIVOT_TIME = 0.28  # s from one step of a turn to the next
TWIST = 0.9  # rad of the shoulders against the hips, to either side, once for every two steps


def walk(script: Script, side: str, _size: float, count: int) -> Stance:
    """Walk `count` steps straight ahead, the foot of `side` first; half steps at both ends."""
    first = 0.6  # of a step length
    distance = (count - 1 + first) * STEP_LENGTH
    # At full speed the hips are midway between the feet whenever a foot lands; that sets both ramps.
    steps_long = count + 1.0
    end = steps_long * STEP_TIME
    script.to(0.0, end, cruise(1.6 / steps_long, 1.1 / steps_long), hips_z=distance)
    script.to(0.0, 0.4, hips_y=0.875)
    for i in range(count + 1):
        landing = min(i + first, count - 1 + first) * STEP_LENGTH
        _step(script, side if i % 2 == 0 else OTHER[side], i * STEP_TIME, landing, last=i == count)
    script.to(end - 0.4, end, hips_y=script.posture["hips_y"])
    return script.stance.after(forward=distance)


def _step(script: Script, side: str, start: float, landing: float, *, last: bool) -> None:
    """Swing the foot of `side` to `landing` metres ahead of the stance, and the other arm with it."""
    sign, swing = SIGN[side], 0.9 * STEP_TIME
    lift, land = start + 0.06, start + 0.06 + swing
    script.to(max(start - 0.16, 0.0), lift + 0.06, **limb(side, pitch=0.65))
    script.to(lift, land, **limb(side, z=NEUTRAL[f"{side}_z"] + landing))
    script.sway(lift, land, **limb(side, y=0.08))
    script.to(lift + 0.08, land - 0.04, **limb(side, pitch=-0.1))
    script.to(land - 0.10, land + 0.04, **limb(side, pitch=0.0))
    script.sway(start, land, hips_y=0.035, hips_x=-0.03 * sign)
    middle = script.posture["l_elevation"]
    swung, turned = (0.0, 0.0) if last else (0.45, 0.12 * sign)
    script.to(start, start + STEP_TIME, hips_yaw=-turned, torso_yaw=1.8 * turned, head_yaw=-0.8 * turned)
    script.to(start, start + STEP_TIME, **limb(OTHER[side], elevation=middle + swung))
    script.to(start, start + STEP_TIME, **limb(side, elevation=middle - swung))


def turn(script: Script, side: str, angle: float, count: int) -> Stance:
    """Turn on the spot by `angle` (radians, positive) towards `side`, in `count` small steps.

    The trunk twists to and fro over the steps, as in an exercise class.
    """
    angle *= SIGN[side]
    for i in range(count):
        # Either foot comes as far as the turn has come by its next step; both end where it ends.
        share = min((i + 1.0) / (count - 1.0), 1.0)
        _pivot(script, side if i % 2 == 0 else OTHER[side], PIVOT_TIME * i, angle * share)
    end = PIVOT_TIME * count + 0.04
    script.to(0.0, end, cruise(1.0 / count, 1.0 / count), hips_yaw=angle)
    script.sway(0.0, end, shaking(count // 2), torso_yaw=TWIST)
    return script.stance.after(turned=angle)


def _pivot(script: Script, side: str, start: float, angle: float) -> None:
    """Lift the foot of `side` and set it down where it stands after turning by `angle`."""
    x, z, yaw = (NEUTRAL[f"{side}_{name}"] for name in ("x", "z", "yaw"))
    cos, sin = math.cos(angle), math.sin(angle)
    place = limb(side, x=x * cos + z * sin, z=z * cos - x * sin, yaw=yaw + angle)
    script.to(start, start + PIVOT_TIME, **place)
    script.sway(start, start + PIVOT_TIME, **limb(side, y=0.07, pitch=0.3))
