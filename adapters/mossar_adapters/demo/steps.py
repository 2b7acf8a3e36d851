"""The moves that go somewhere: walk and turn. See `moves` for the conventions."""

import math

from mossar_adapters.demo.body import NEUTRAL
from mossar_adapters.demo.moves import OTHER, SIGN, limb
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import cruise

STEP_TIME = 0.55  # s
STEP_LENGTH = 0.60  # m


def walk(script: Script, side: str, steps: int) -> Stance:
    """Walk straight ahead, the foot of `side` first; a half step at either end brings the feet together."""
    first = 0.6  # of a step length
    distance = (steps - 1 + first) * STEP_LENGTH
    # At full speed the hips are midway between the feet whenever a foot lands; that sets both ramps.
    steps_long = steps + 1.0
    end = steps_long * STEP_TIME
    script.to(0.0, end, cruise(1.6 / steps_long, 1.1 / steps_long), hips_z=distance)
    script.to(0.0, 0.5, hips_y=0.875, hips_pitch=0.05)
    for i in range(steps + 1):
        landing = min(i + first, steps - 1 + first) * STEP_LENGTH
        _step(script, side if i % 2 == 0 else OTHER[side], i * STEP_TIME, landing, last=i == steps)
    script.to(end - 0.4, end, hips_y=NEUTRAL["hips_y"], hips_pitch=0.0)
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
    ahead, behind = (-1.4, -1.4) if last else (-0.95, -1.9)
    turned = 0.0 if last else 0.12 * sign
    script.to(start, start + STEP_TIME, hips_yaw=-turned, torso_yaw=1.8 * turned, head_yaw=-0.8 * turned)
    script.to(start, start + STEP_TIME, **limb(OTHER[side], elevation=ahead), **limb(side, elevation=behind))


def turn(script: Script, side: str, angle: float) -> Stance:
    """Turn on the spot by `angle` (radians, positive) towards `side`, in two steps, or three beyond 100°."""
    angle *= SIGN[side]
    shares: tuple[tuple[str, float], ...] = ((side, 1.0), (OTHER[side], 1.0))
    if abs(angle) > math.radians(100):
        shares = ((side, 0.55), (OTHER[side], 1.0), (side, 1.0))
    for i, (foot, share) in enumerate(shares):
        _pivot(script, foot, 0.04 + 0.32 * i, angle * share)
    end = 0.04 + 0.32 * len(shares) + 0.06
    script.to(0.0, end, hips_yaw=angle)
    script.sway(0.0, end, head_yaw=0.4 * SIGN[side], torso_yaw=0.3 * SIGN[side], hips_y=-0.03)
    script.sway(0.0, end, l_elevation=0.35, r_elevation=0.35, l_azimuth=0.4, r_azimuth=0.4)
    return script.stance.after(turned=angle)


def _pivot(script: Script, side: str, start: float, angle: float) -> None:
    """Lift the foot of `side` and set it down where it stands after turning by `angle`."""
    x, z, yaw = (NEUTRAL[f"{side}_{name}"] for name in ("x", "z", "yaw"))
    cos, sin = math.cos(angle), math.sin(angle)
    place = limb(side, x=x * cos + z * sin, z=z * cos - x * sin, yaw=yaw + angle)
    script.to(start, start + 0.38, **place)
    script.sway(start, start + 0.38, **limb(side, y=0.07, pitch=0.3))
