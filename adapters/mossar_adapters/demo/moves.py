"""The moves on the spot: punch, kick, jump, wave, squat.

Each is a function that writes a series of strokes, out of its posture and back to it. Times are seconds at pace
1, angles radians; `side` is "l" or "r", the side of the limb that acts; `size` scales the motion, 1 is full;
`count` is how often it is repeated.
"""

from mossar_adapters.demo.postures import OTHER, SIGN, limb
from mossar_adapters.demo.script import Script, Stance
from mossar_adapters.demo.strokes import Hops, ballistic, shaking


def punch(script: Script, side: str, size: float, count: int) -> Stance:
    """Strike straight ahead with the fist of `side`, again and again, back to the guard every time."""
    sign = SIGN[side]
    for i in range(count):
        out, back = 0.46 * i, 0.46 * i + 0.20
        script.to(out, back, **limb(side, azimuth=0.5, elevation=0.1, reach=0.53, swivel=0.8))
        script.to(out, back, torso_yaw=-0.5 * sign, hips_yaw=-0.2 * sign, hips_z=0.15)
        script.to(out, back, torso_pitch=0.16 * size, head_yaw=0.5 * sign)
        script.back(back, back + 0.26)
    return script.stance


def kick(script: Script, side: str, size: float, count: int) -> Stance:
    """Kick forwards above the belt, again and again, the knee staying up in between."""
    sign = SIGN[side]
    for i in range(count):
        out, back = 0.60 * i, 0.60 * i + 0.28
        script.to(out, back, **limb(side, y=0.84 + 0.14 * size, z=0.92, pitch=-0.8))
        script.to(out, back, torso_pitch=-0.2, hips_pitch=-0.2, hips_yaw=-0.2 * sign, hips_z=0.03)
        script.to(out, back, **limb(OTHER[side], azimuth=0.5))
        script.back(back, back + 0.30)
    return script.stance


def jump(script: Script, _side: str, size: float, count: int) -> Stance:
    """Jump straight up with both feet, again and again, the arms beating like wings."""
    script.pace = 1.0  # the time of a free fall does not depend on the tempo
    hops = Hops(speed=0.75 + 0.85 * size, count=count)
    script.sway(0.0, hops.duration, hops, hips_y=1.0)
    for i in range(count):
        off = hops.take_off + i * hops.period
        down = off + hops.flight
        script.to(off - 0.12, off + 0.10, l_elevation=0.75, r_elevation=0.75)
        script.to(off - 0.14, off + 0.02, l_pitch=0.6, r_pitch=0.6)
        script.sway(off, down, ballistic, l_y=hops.rise, r_y=hops.rise)
        script.sway(off, down, l_y=0.05, r_y=0.05)
        script.to(down - 0.10, down + 0.06, l_pitch=0.0, r_pitch=0.0)
        script.back(down - 0.10, down + 0.14)
    return script.stance


def wave(script: Script, side: str, size: float, count: int) -> Stance:
    """Wave the raised hand to and fro."""
    sign, end = SIGN[side], 0.5 * count
    script.sway(0.0, end, shaking(count), **limb(side, elevation=0.42 * size, reach=-0.02))
    script.sway(0.0, end, shaking(count), torso_roll=0.06 * sign, hips_x=0.015 * sign, head_yaw=0.05)
    return script.stance


def squat(script: Script, _side: str, size: float, count: int) -> Stance:
    """Bend the knees deeply and come up again, again and again."""
    low = 0.92 - 0.34 * size
    for i in range(count):
        down, up = 1.08 * i, 1.08 * i + 0.54
        script.to(down, up, hips_y=low, hips_z=-0.17, hips_pitch=0.42, torso_pitch=0.33, head_pitch=-0.5)
        script.to(down, up, l_elevation=0.7, r_elevation=0.7)
        script.back(up, up + 0.54)
    return script.stance
