"""The moves on the spot: punch, kick, jump, wave, squat.

Each is a function that writes its strokes and returns the stance it ends in. Times are seconds at pace 1,
angles radians; `side` is "l" or "r", the side of the limb that acts.
"""

from mossar_adapters.demo.body import NEUTRAL
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import Hop, ballistic, shaking

GUARD = {"azimuth": -0.3, "elevation": 0.15, "reach": 0.27, "swivel": 0.35}
SIGN = {"l": 1.0, "r": -1.0}
OTHER = {"l": "r", "r": "l"}


def limb(side: str, **values: float) -> dict[str, float]:
    """Return channel values of the arm or leg of one side."""
    return {f"{side}_{name}": value for name, value in values.items()}


def punch(script: Script, side: str, size: float) -> Stance:
    """Step into the guard, strike straight ahead with the fist of `side`, drop the guard and step back."""
    sign, other = SIGN[side], OTHER[side]
    stance = NEUTRAL[f"{other}_z"]
    script.to(0.0, 0.34, **limb("l", **GUARD), **limb("r", **GUARD))
    script.to(0.0, 0.34, **limb(other, z=stance + 0.30))
    script.sway(0.0, 0.34, **limb(other, y=0.06))
    script.to(0.0, 0.34, hips_y=0.85, hips_z=0.08, torso_yaw=0.4 * sign, torso_pitch=0.08)
    script.to(0.36, 0.58, **limb(side, azimuth=0.7, elevation=0.1, reach=0.53, swivel=0.8))
    script.to(0.36, 0.58, torso_yaw=-0.65 * sign, hips_yaw=-0.25 * sign, hips_z=0.17)
    script.to(0.36, 0.58, torso_pitch=0.16 * size, head_yaw=0.6 * sign, **limb(side, pitch=0.5))
    script.to(0.60, 0.82, **limb(side, **GUARD), **limb(side, pitch=0.1))
    script.to(0.60, 0.82, torso_yaw=0.1 * sign, hips_yaw=0.0, hips_z=0.10, head_yaw=0.0)
    script.sway(0.84, 1.18, **limb(other, y=0.05))
    script.ease(0.82, 1.20)
    return script.stance


def kick(script: Script, side: str, size: float) -> Stance:
    """Shift the weight, lift the knee, kick forwards above the belt, step back down."""
    sign, other = SIGN[side], OTHER[side]
    foot = sign * 0.09
    script.to(0.0, 0.34, hips_x=-0.08 * sign, hips_y=0.905, torso_pitch=0.1, **limb(other, **GUARD))
    script.to(0.0, 0.34, **limb(side, azimuth=0.3, elevation=-0.2, reach=0.40))
    script.to(0.10, 0.42, **limb(side, x=foot, y=0.50, z=0.42, pitch=0.3))
    script.to(0.40, 0.62, **limb(side, y=0.84 + 0.16 * size, z=0.94, pitch=-0.8))
    script.to(0.40, 0.62, torso_pitch=-0.25, hips_pitch=-0.25, hips_yaw=-0.2 * sign, hips_z=0.06)
    script.to(0.40, 0.62, **limb(side, azimuth=0.7, elevation=-1.9, reach=0.5))
    script.to(0.64, 0.86, **limb(side, y=0.45, z=0.36, pitch=0.3), torso_pitch=0.08, hips_pitch=0.0)
    script.ease(0.84, 1.22)
    return script.stance


def jump(script: Script, _side: str, size: float) -> Stance:
    """Crouch with the arms back, jump straight up with the arms forward, land softly."""
    script.pace = 1.0  # free fall takes its time whatever the tempo
    hop = Hop(speed=1.0 + 1.25 * size)
    off, down, end = hop.take_off, hop.take_off + hop.flight, hop.duration
    script.sway(0.0, end, hop, hips_y=1.0)
    script.to(0.0, 0.40, hips_z=-0.10, hips_pitch=0.35, torso_pitch=0.4, head_pitch=-0.4)
    script.to(0.0, 0.40, l_elevation=-2.3, r_elevation=-2.3, l_azimuth=0.2, r_azimuth=0.2)
    script.to(0.38, off + 0.06, hips_z=0.0, hips_pitch=0.0, torso_pitch=-0.08, head_pitch=0.0)
    script.to(0.30, off + 0.20, l_elevation=0.7, r_elevation=0.7, l_reach=0.50, r_reach=0.50)
    script.to(0.42, off + 0.02, l_pitch=0.7, r_pitch=0.7)
    script.sway(off, down, ballistic, l_y=hop.rise, r_y=hop.rise)
    script.sway(off, down, l_y=0.06, r_y=0.06)
    script.to(down - 0.10, down + 0.07, l_pitch=0.0, r_pitch=0.0)
    script.to(down - 0.12, down + 0.22, hips_z=-0.07, hips_pitch=0.25, torso_pitch=0.3, head_pitch=-0.3)
    script.to(down - 0.2, down + 0.24, l_elevation=-0.9, r_elevation=-0.9)
    script.ease(down + 0.22, end)
    return script.stance


def wave(script: Script, side: str, size: float) -> Stance:
    """Raise the hand beside the head, wave it a few times, lower the arm."""
    sign = SIGN[side]
    cycles, beat = 3, 0.50
    end = 0.42 + cycles * beat
    script.to(0.0, 0.46, **limb(side, azimuth=1.3, elevation=0.95, reach=0.44, swivel=-0.2))
    script.to(0.0, 0.46, hips_x=0.08 * sign, torso_roll=-0.14 * sign, head_yaw=0.2 * sign)
    script.to(0.0, 0.46, **limb(OTHER[side], azimuth=1.1, elevation=-0.95, reach=0.5))
    script.sway(0.42, end, shaking(cycles), **limb(side, elevation=0.42 * size, reach=-0.02))
    script.sway(0.42, end, shaking(cycles), torso_roll=0.06 * sign, hips_x=0.015 * sign, head_yaw=0.05)
    script.ease(end - 0.02, end + 0.42)
    return script.stance


def squat(script: Script, _side: str, size: float) -> Stance:
    """Bend the knees deeply with the arms stretched forwards, and stand up again."""
    low = 0.92 - 0.38 * size
    script.to(0.0, 0.80, hips_y=low, hips_z=-0.17, hips_pitch=0.45, torso_pitch=0.35, head_pitch=-0.5)
    script.to(0.0, 0.75, l_elevation=0.75, r_elevation=0.75, l_azimuth=-0.05, r_azimuth=-0.05)
    script.ease(0.90, 1.70)
    return script.stance
