"""The performer's body: its skeleton, its pose channels, and joint positions from them.

Axes: right-handed, metres, +y up; at heading 0 the performer faces +z and its left side is +x.

A pose is a vector of `CHANNELS`. Trunk and head are posed by joint rotations. Each arm is given by where the
hand is seen from the shoulder (azimuth outwards, elevation, reach) and by the swivel of the elbow about that
line; each leg by where the toes stand on the floor and by the pitch of the foot. Elbows and knees follow from
the lengths of the two bones, so that bone lengths are constant and a standing foot does not slide.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton

Floats = NDArray[np.float64]

SKELETON: Final = Skeleton(
    names=(
        *("Hips", "Spine", "Chest", "Neck", "Head"),
        *("LeftShoulder", "LeftUpperArm", "LeftLowerArm", "LeftHand"),
        *("RightShoulder", "RightUpperArm", "RightLowerArm", "RightHand"),
        *("LeftUpperLeg", "LeftLowerLeg", "LeftFoot", "LeftToes"),
        *("RightUpperLeg", "RightLowerLeg", "RightFoot", "RightToes"),
    ),
    parents=(-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 15, 0, 17, 18, 19),
)

# Metres, of an adult 1.70 m tall; `Head` is the middle of the head.
SPINE: Final = (0.0, 0.11, 0.0)
CHEST: Final = (0.0, 0.15, 0.0)
NECK: Final = (0.0, 0.23, 0.0)
HEAD: Final = (0.0, 0.15, 0.02)
COLLAR: Final = (0.03, 0.19, 0.0)
SHOULDER: Final = (0.14, -0.01, 0.0)
UPPER_ARM: Final = 0.28
LOWER_ARM: Final = 0.26
HIP: Final = (0.09, -0.04, 0.0)
THIGH: Final = 0.41
SHANK: Final = 0.40
FOOT: Final = (0.0, -0.06, 0.14)

_STRAIGHTEST = 0.998  # a limb reaches at most this share of its length: the joint between never snaps

CHANNELS: Final = (
    *("hips_x", "hips_y", "hips_z", "hips_yaw", "hips_pitch", "hips_roll"),
    *("torso_yaw", "torso_pitch", "torso_roll", "head_yaw", "head_pitch"),
    *("l_azimuth", "l_elevation", "l_reach", "l_swivel"),
    *("r_azimuth", "r_elevation", "r_reach", "r_swivel"),
    *("l_x", "l_y", "l_z", "l_yaw", "l_pitch"),
    *("r_x", "r_y", "r_z", "r_yaw", "r_pitch"),
)
CHANNEL: Final = {name: i for i, name in enumerate(CHANNELS)}

# Standing at ease: metres and radians; feet and hips as seen from the point of the floor below the hips.
NEUTRAL: Final[dict[str, float]] = {
    "hips_y": 0.92,
    "l_x": 0.11,
    "r_x": -0.11,
    "l_yaw": 0.15,
    "r_yaw": -0.15,
    **dict.fromkeys(("l_azimuth", "r_azimuth"), 0.6),
    **dict.fromkeys(("l_elevation", "r_elevation"), -1.4),
    **dict.fromkeys(("l_reach", "r_reach"), 0.53),
    **dict.fromkeys(("l_swivel", "r_swivel"), 0.5),
    **dict.fromkeys(("l_y", "r_y"), 0.02),
    **dict.fromkeys(("l_z", "r_z"), 0.13),
}


def pose(values: dict[str, float]) -> Floats:
    """Return `values` by channel name as a vector, the others 0.

    Args:
        values: Metres and radians by channel name.

    Returns:
        (C,) float64.
    """
    vector = np.zeros(len(CHANNELS))
    for name, value in values.items():
        vector[CHANNEL[name]] = value
    return vector


def joint_positions(poses: Floats) -> Floats:
    """Return the positions of the joints.

    Args:
        poses: (n, C), metres and radians, in the order of `CHANNELS`.

    Returns:
        (n, J, 3) float64, metres, in the order of `SKELETON`.
    """
    channel = dict(zip(CHANNELS, poses.T, strict=True))
    out = np.empty((len(poses), len(SKELETON), 3))
    hips = np.stack([channel["hips_x"], channel["hips_y"], channel["hips_z"]], axis=-1)
    frame = _rotation(channel["hips_yaw"], channel["hips_pitch"], channel["hips_roll"])
    # Spine and chest share the bend of the torso, which keeps the trunk from folding at one joint.
    bend = _rotation(*(channel[f"torso_{axis}"] / 2 for axis in ("yaw", "pitch", "roll")))
    spine_frame = _compose(frame, bend)
    chest_frame = _compose(spine_frame, bend)
    head_frame = _compose(chest_frame, _rotation(channel["head_yaw"], channel["head_pitch"], 0 * hips[:, 0]))
    spine = hips + _turned(frame, SPINE)
    chest = spine + _turned(spine_frame, CHEST)
    neck = chest + _turned(chest_frame, NECK)
    out[:, 0], out[:, 1], out[:, 2], out[:, 3] = hips, spine, chest, neck
    out[:, 4] = neck + _turned(head_frame, HEAD)
    for first, side, sign in ((5, "l", 1.0), (9, "r", -1.0)):
        out[:, first : first + 4] = _arm(channel, side, sign, chest, chest_frame)
    for first, side, sign in ((13, "l", 1.0), (17, "r", -1.0)):
        out[:, first : first + 4] = _leg(channel, side, sign, hips, frame)
    return out


def _arm(channel: dict[str, Floats], side: str, sign: float, chest: Floats, frame: Floats) -> Floats:
    """Return (n, 4, 3): collar, shoulder, elbow and hand of one arm; `sign` is +1 on the left."""
    azimuth, elevation = channel[f"{side}_azimuth"], channel[f"{side}_elevation"]
    swivel = channel[f"{side}_swivel"]
    sin_a, cos_a = np.sin(azimuth), np.cos(azimuth)
    sin_e, cos_e = np.sin(elevation), np.cos(elevation)
    towards = np.stack([sign * sin_a * cos_e, sin_e, cos_a * cos_e], axis=-1)
    below = np.stack([sign * sin_a * sin_e, -cos_e, cos_a * sin_e], axis=-1)
    sideways = np.stack([sign * cos_a, np.zeros_like(sin_a), -sin_a], axis=-1)
    bulge = np.cos(swivel)[:, None] * below + np.sin(swivel)[:, None] * sideways
    collar = chest + _turned(frame, (sign * COLLAR[0], *COLLAR[1:]))
    shoulder = collar + _turned(frame, (sign * SHOULDER[0], *SHOULDER[1:]))
    elbow, hand = _two_bones(UPPER_ARM, LOWER_ARM, channel[f"{side}_reach"], towards, bulge)
    return np.stack([collar, shoulder, shoulder + _moved(frame, elbow), shoulder + _moved(frame, hand)], 1)


def _leg(channel: dict[str, Floats], side: str, sign: float, hips: Floats, frame: Floats) -> Floats:
    """Return (n, 4, 3): hip, knee, ankle and toes of one leg; `sign` is +1 on the left."""
    toes = np.stack([channel[f"{side}_{axis}"] for axis in "xyz"], axis=-1)
    yaw = channel[f"{side}_yaw"]
    foot = _turned(_rotation(yaw, channel[f"{side}_pitch"], 0 * yaw), FOOT)
    hip = hips + _turned(frame, (sign * HIP[0], *HIP[1:]))
    to_ankle = toes - foot - hip
    reach = np.sqrt(np.sum(to_ankle**2, axis=-1))
    towards = to_ankle / reach[:, None]
    knee_yaw = (yaw + channel["hips_yaw"]) / 2
    hinge = np.stack([np.cos(knee_yaw), 0 * yaw, -np.sin(knee_yaw)], axis=-1)
    bulge = np.cross(towards, hinge)
    bulge /= np.sqrt(np.sum(bulge**2, axis=-1))[:, None]
    knee, ankle = _two_bones(THIGH, SHANK, reach, towards, bulge)
    return np.stack([hip, hip + knee, hip + ankle, hip + ankle + foot], 1)


def _two_bones(
    upper: float, lower: float, reach: Floats, towards: Floats, bulge: Floats
) -> tuple[Floats, Floats]:
    """Return the middle joint and the end of a limb of two bones, as seen from its start.

    Args:
        upper: Length of the first bone, m.
        lower: Length of the second bone, m.
        reach: (n,) distance from start to end, m; limited to the reach of the bones.
        towards: (n, 3) unit vectors from the start to the end.
        bulge: (n, 3) unit vectors across `towards`, to where the middle joint points.
    """
    reach = np.clip(reach, 1.1 * abs(upper - lower) + 0.05, _STRAIGHTEST * (upper + lower))
    along = (upper**2 + reach**2 - lower**2) / (2 * reach)
    across = np.sqrt(upper**2 - along**2)
    return along[:, None] * towards + across[:, None] * bulge, reach[:, None] * towards


def _rotation(yaw: Floats, pitch: Floats, roll: Floats) -> Floats:
    """Return (n, 3, 3): roll about +z, then pitch about +x (forwards), then yaw about +y (to the left)."""
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    rows = (
        (cy * cr + sy * sp * sr, sy * sp * cr - cy * sr, sy * cp),
        (cp * sr, cp * cr, -sp),
        (cy * sp * sr - sy * cr, sy * sr + cy * sp * cr, cy * cp),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _compose(first: Floats, second: Floats) -> Floats:
    product: Floats = np.einsum("nij,njk->nik", first, second)
    return product


def _turned(frame: Floats, offset: tuple[float, ...]) -> Floats:
    return _moved(frame, np.tile(offset, (len(frame), 1)))


def _moved(frame: Floats, offsets: Floats) -> Floats:
    moved: Floats = np.einsum("nij,nj->ni", frame, offsets)
    return moved
