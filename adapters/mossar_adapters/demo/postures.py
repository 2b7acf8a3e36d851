"""Postures: how the performer holds itself in each move, and where a move begins and ends."""

from typing import Final

from mossar_adapters.demo.body import NEUTRAL, Floats, pose

SIGN: Final = {"l": 1.0, "r": -1.0}
OTHER: Final = {"l": "r", "r": "l"}

Values = dict[str, float]


def limb(side: str, **values: float) -> Values:
    """Return channel values of the arm or leg of one side."""
    return {f"{side}_{name}": value for name, value in values.items()}


def both(**values: float) -> Values:
    """Return the same channel values for both arms or legs."""
    return limb("l", **values) | limb("r", **values)


def at_ease(_side: str) -> Values:
    """Standing upright, arms hanging."""
    return {}


def stride(_side: str) -> Values:
    """Ready to walk briskly: elbows bent."""
    return {"hips_pitch": 0.05, "hips_y": 0.90, **both(elevation=-0.95, azimuth=0.15, reach=0.38)}


def guard(side: str) -> Values:
    """A boxer's guard, fists before the chin, the foot of the other side in front."""
    sign, other = SIGN[side], OTHER[side]
    fists = both(azimuth=-0.3, elevation=0.15, reach=0.27, swivel=0.35)
    feet = limb(other, z=NEUTRAL[f"{other}_z"] + 0.30) | limb(side, pitch=0.1)
    trunk = {"hips_y": 0.85, "hips_z": 0.10, "torso_yaw": 0.3 * sign, "torso_pitch": 0.12}
    return fists | feet | trunk


def chamber(side: str) -> Values:
    """On one leg, the knee of `side` raised, the arms apart for balance."""
    sign = SIGN[side]
    trunk = {"hips_x": -0.08 * sign, "hips_y": 0.905, "torso_pitch": -0.08, "hips_pitch": -0.1}
    arms = both(azimuth=1.0, elevation=-0.35, reach=0.46, swivel=0.2)
    return trunk | arms | limb(side, x=0.09 * sign, y=0.52, z=0.40, pitch=0.3)


def poised(_side: str) -> Values:
    """Ready to jump: knees bent a little, arms raised sideways."""
    return {"hips_y": 0.89, **both(azimuth=1.45, elevation=0.35, reach=0.51, swivel=0.1)}


def hailing(side: str) -> Values:
    """One hand raised beside the head, the other on the hip, the weight on one leg."""
    sign = SIGN[side]
    trunk = {"hips_x": 0.07 * sign, "torso_roll": -0.14 * sign, "head_yaw": 0.2 * sign}
    raised = limb(side, azimuth=1.3, elevation=0.95, reach=0.44, swivel=-0.2)
    return trunk | raised | limb(OTHER[side], azimuth=0.2, elevation=-1.25, reach=0.42, swivel=1.2)


def reaching(_side: str) -> Values:
    """Knees bent, arms stretched forwards."""
    trunk = {"hips_y": 0.81, "hips_z": -0.06, "hips_pitch": 0.18, "torso_pitch": 0.16, "head_pitch": -0.2}
    return trunk | both(azimuth=-0.05, elevation=0.3, reach=0.53)


def joined(_side: str) -> Values:
    """Upright, the hands joined before the chest."""
    return {"hips_y": 0.91, **both(azimuth=-1.0, elevation=-0.5, reach=0.24, swivel=0.6)}


POSTURES: Final = {
    "rest": at_ease,
    "stand": at_ease,
    "walk": stride,
    "punch": guard,
    "kick": chamber,
    "jump": poised,
    "wave": hailing,
    "squat": reaching,
    "turn": joined,
}


def posture(kind: str, side: str) -> Floats:
    """Return the posture of a move as a pose (C,), seen from where the performer stands.

    Args:
        kind: A key of `POSTURES`.
        side: "l" or "r".
    """
    return pose(NEUTRAL | POSTURES[kind](side))
