"""Noise: how much of the velocity is the sensor's, so that a person who stands still does not flood.

A sensor that errs by a millimetre moves all joints all the time: at 120 Hz that is as much path as a slow walk.
No limit on the velocity tells the two apart, but the direction does: motion goes on, noise turns back. The
displacement of a joint that only trembles has the correlation -1/2 with the one before, that of a moving joint
one near 1. So while displacements are on the whole turned back, the path is the sensor's, and what it adds to
the velocity is known from then on. Where that is too much for the threshold line,

    displacements are smoothed (first-order low-pass, time constant at most `SLOWEST_SMOOTHING`), and
    the range does not fall below where θ · range is `noise_margin` times the noise that is left.

Where poses are low-pass filtered (level `motion`), small movements must not be silenced: there the velocity is that of the
filtered poses while noise is loud, and the range rises to at most `MOST_RAISED` times what it is. A joint that jumps turns back, too, while others
move, so there the noise is at most what the path was at its quietest of late (the minimum statistics of Martin 2001).

So that a stream need not begin with a false onset, its first moment counts as noise, too.

Recordings with little noise, and performers who never rest, go through unchanged but for that. This is ours; preset
`paper` and the `fixed` range have it off.
"""

from typing import Any

import numpy as np

from mossar_stream.algorithm.clock import TIME_ROUNDING
from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_product, page_sum
from mossar_stream.memory.joint_pages import (
    LAST_X,
    LAST_Y,
    LAST_Z,
    LINES,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    PAGE,
    SMOOTH_X,
    SMOOTH_Y,
    SMOOTH_Z,
    STEP,
    WORK,
    line_sum,
    page_of,
)

MEMORY = 0.15  # s, time constant of the averages
TURNED_BACK = -0.1  # correlation of successive displacements below which they are noise
BEGINNING = 0.05  # s, at the start of a stream, in which every movement may be noise
STILLNESS = 0.1  # s, without any displacement, after which the sensor is exactly still; shorter ones are repeated frames
DOUBT = 0.5  # what is added to the estimate for each frame's share in it
SLOWEST_SMOOTHING = 0.1  # s, time constant of the smoothing
DOUBLING = 5.0  # s, in which the quietest path that is remembered doubles
# Where poses are filtered, θ · range is raised so many standard deviations above what the noise adds to the velocity, but
# not beyond so many times what it would be without noise.
DEVIATIONS, MOST_RAISED = 4.0, 3.0
UNEVEN = 1.6  # a step in time so many times the usual one has lost frames; in it, motion may turn back
ALWAYS_EVEN, NEVER_EVEN = (
    0.03,
    0.1,
)  # s, steps that are even in any case (frames may come in bursts), and in no case
SHORTER_STEP, LONGER_STEP = 0.8, 1.04  # how the usual step follows: to where about one step in six is shorter

RECENT_SUMS = np.dtype(  # leaky sums over the last frames of a take
    [
        ("time", "f8"),  # s, since the last frame that was not a repetition
        ("span", "f8"),  # s, that the following sums stand for
        ("path", "f8"),  # m
        ("turn", "f8"),  # s, correlation of successive displacements
        ("squares", "f8"),  # m², of the last displacements
        ("still", "f8"),  # s, for which exactly nothing moved before the last displacement
    ],
)
NOISE = np.dtype(  # what is known of the sensor, which outlasts a take
    [
        ("known", "i8"),  # whether it was ever calm
        ("silent", "i8"),  # whether the sensor was ever exactly still: until it is calm, it has no noise
        ("heard", "f8"),  # s, of movement
        ("estimate", "f8"),  # m/s, path of the noise of all joints
        (
            "aside",
            "f8",
        ),  # m/s, the estimate where the setting noise_margin is 0: only the activity knows of it
        ("quietest", "f8"),  # m/s, path of all joints when it was quietest of late; 0 if that is not known
        ("loud", "i8"),  # whether the velocity is that of filtered poses
        ("floor", "f8"),  # m, the range does not fall below it
        ("step", "f8"),  # s, usual time between frames
        ("smooth", "i8"),  # whether the last displacement was smoothed
        ("recent", RECENT_SUMS),
    ],
)


@kernel
def start_noise(recent):
    """Begin a take: nothing was heard of late."""
    recent.time = 0.0
    recent.span = 0.0
    recent.path = 0.0
    recent.turn = 0.0
    recent.squares = 0.0
    recent.still = 0.0


def forget_noise(noise: Any) -> None:
    """Forget the sensor's noise, but not its rate, outside compiled code."""
    for name in ("known", "silent", "heard", "estimate", "aside", "quietest", "loud", "floor"):
        noise[name] = 0


@inline_kernel
def calm_noise(noise, plan, largest, body, displacement, dt):
    """Take a frame in, set `noise.floor`, and return the frame's path with the noise smoothed out of it.

    Where poses are filtered it sets `noise.loud` instead, and returns the path as it is.

    Args:
        noise: NOISE.
        plan: PLAN.
        largest: m, velocity so far.
        body: Displacements of the joints, now, before, and smoothed; 0 where one is missing or back after a gap.
        displacement: m, path of all; repeated frames have none and say nothing.
        dt: s since the last frame, 0 for the first.

    Returns:
        Path of all joints, m.
    """
    hear_noise(noise, body, plan.padded_joints, displacement, dt)
    level = noise_level(noise) if plan.is_filtered == 1 else noise.estimate
    loudness = level * plan.window * plan.noise_margin
    line = plan.theta * max(largest, plan.range_floor)
    noise.floor = 0.0
    noise.loud = 1 if plan.is_filtered == 1 and dt > 0.0 and loudness > line else 0
    if dt <= 0.0 or plan.is_filtered == 1 or not loudness > line:  # it does not come too near to the line
        noise.smooth = 0
        return displacement
    share = _share(loudness, line, dt)
    noise.floor = loudness * share / np.sqrt(2.0 - share) / plan.theta
    return _smooth(noise, body, displacement, share)


@inline_kernel
def hear_noise(noise, body, padded_joints, displacement, dt):
    """Learn from a frame what the sensor's noise is; see `calm_noise`."""
    recent = noise.recent
    recent.time += dt
    if displacement > 0.0 or dt <= 0.0:
        turned = _turned(recent, body, padded_joints)
        if _is_even(noise, recent.time):
            _listen(noise, turned, displacement)
        else:
            recent.squares = 0.0  # nothing can be compared with this displacement
        recent.still = recent.time - dt
        noise.silent |= 1 if recent.still >= STILLNESS - TIME_ROUNDING else 0
        recent.time = 0.0


@inline_kernel
def ends_stillness(noise):
    """Tell whether the last frame is the first with a displacement after exact stillness."""
    return noise.recent.time == 0.0 and noise.recent.still >= STILLNESS - TIME_ROUNDING


@inline_kernel
def hear_aside(noise, body, padded_joints, displacement, dt):
    """Learn from a frame what the noise is without letting anything but the activity know."""
    noise.estimate = noise.aside
    hear_noise(noise, body, padded_joints, displacement, dt)
    noise.aside, noise.estimate = noise.estimate, 0.0


@inline_kernel
def noise_level(noise):
    """Return the path of the noise of all joints where poses are filtered, m/s."""
    return min(noise.estimate, noise.quietest) if noise.quietest > 0.0 else noise.estimate


@inline_kernel
def noise_floor(left, plan, largest):
    """Return below what the range does not fall while noise is loud and poses are filtered, m.

    The rms of 3 J normal numbers has a standard deviation of 1/√(6 J) of itself.

    Args:
        left: m, what the noise adds to the velocity of the filtered poses.
        plan: PLAN.
        largest: m, velocity so far.
    """
    least = left * (1.0 + DEVIATIONS / np.sqrt(6.0 * plan.moving_joints))
    return min(least / plan.theta, MOST_RAISED * max(largest, plan.range_floor))


@inline_kernel
def _turned(recent, body, padded_joints):
    """Return the correlation of the displacements with the last ones, and keep them."""
    product = squares = 0.0
    for first in range(0, padded_joints, PAGE):
        page = page_of(body, first)
        _turn(page)
        product += page_sum(page, WORK)
        squares += page_product(page, STEP, STEP)
    scale = np.sqrt(squares * recent.squares)
    recent.squares = squares
    return product / scale if scale > 0.0 else 0.0


@inline_kernel
def _is_even(noise, step):
    """Tell whether the frame follows the last one without a loss, and learn how long that takes."""
    if step <= 0.0 or (noise.step == 0.0 and step > NEVER_EVEN + TIME_ROUNDING):
        return False
    if noise.step == 0.0 or step < noise.step - TIME_ROUNDING:
        noise.step = max(step, SHORTER_STEP * noise.step)
    even = step <= min(NEVER_EVEN, max(ALWAYS_EVEN, UNEVEN * noise.step)) + TIME_ROUNDING
    noise.step = max(noise.step, min(step, LONGER_STEP * noise.step))
    return even


@inline_kernel
def _turn(page):
    for j in range(PAGE):
        x, y, z = page[j + MOVED_X], page[j + MOVED_Y], page[j + MOVED_Z]
        page[j + WORK] = x * page[j + LAST_X] + y * page[j + LAST_Y] + z * page[j + LAST_Z]
        page[j + LAST_X], page[j + LAST_Y], page[j + LAST_Z] = x, y, z


@inline_kernel
def _listen(noise, turned, displacement):
    """Take the path of a frame for noise if joints keep turning back."""
    recent = noise.recent
    time = recent.time
    keep = MEMORY / (MEMORY + time)
    recent.span = keep * (recent.span + time)
    recent.path = keep * (recent.path + displacement)
    recent.turn = keep * (recent.turn + turned * time)
    noise.heard += time
    if recent.span > BEGINNING + TIME_ROUNDING:
        path = recent.path / recent.span
        least = noise.quietest * np.exp2(time / DOUBLING)
        noise.quietest = min(least, path) if least > 0.0 else path
    is_noise = recent.turn < TURNED_BACK * recent.span
    if is_noise:
        noise.known = 1
    if is_noise or (noise.known == 0 and noise.heard < BEGINNING - TIME_ROUNDING):
        # The average of few frames may be too low.
        noise.estimate = recent.path / recent.span * (1.0 + DOUBT * time / recent.span)
    elif noise.known == 0:
        noise.estimate = 0.0


@kernel
def _share(loudness, line, dt):
    """Return the weight of the newest displacement that leaves as little noise as the line allows.

    A weight of a leaves a/√(2 - a) of the path of white noise.
    """
    k = (line / loudness) ** 2
    return max(dt / (dt + SLOWEST_SMOOTHING), 0.5 * (np.sqrt(k * k + 8.0 * k) - k))


@kernel
def _smooth(noise, body, displacement, share):
    """Smooth the displacements, and return the path of what is left."""
    # Smoothing begins from rest, for it is there that noise becomes known.
    keep = 1.0 - share if noise.smooth == 1 else 0.0
    noise.smooth = 1
    take = share if displacement > 0.0 else 0.0
    for first in range(0, len(body) // LINES, PAGE):
        _smooth_page(page_of(body, first), np.float32(keep), np.float32(take))
    raw, smooth = line_sum(body, STEP), line_sum(body, WORK)
    return smooth * displacement / raw if raw > 0.0 else smooth


@kernel
def _smooth_page(page, keep, take):
    for j in range(PAGE):
        x = keep * page[j + SMOOTH_X] + take * page[j + LAST_X]
        y = keep * page[j + SMOOTH_Y] + take * page[j + LAST_Y]
        z = keep * page[j + SMOOTH_Z] + take * page[j + LAST_Z]
        page[j + SMOOTH_X], page[j + SMOOTH_Y], page[j + SMOOTH_Z] = x, y, z
        page[j + WORK] = np.sqrt(x * x + y * y + z * z)
