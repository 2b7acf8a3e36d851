"""Noise: how much of the velocity is the sensor's, so that a person who stands still does not flood.

A sensor that errs by a millimetre moves all joints all the time: at 120 Hz that is as much path as a slow walk.
No limit on the velocity tells the two apart, but the direction does: motion goes on, noise turns back. The
displacement of a joint that only trembles has the correlation -1/2 with the one before, that of a moving joint
one near 1. So while displacements are on the whole turned back, the path is the sensor's, and what it adds to
the velocity is known from then on. Where that is too much for the threshold line,

    displacements are smoothed (first-order low-pass, time constant at most `SLOWEST`), and
    the range does not fall below where θ · range is `noise_margin` times the noise that is left.

So that a stream need not begin with a false onset, its first moment counts as noise, too.

Recordings with little noise, and performers who never rest, go through unchanged but for that. This is ours; preset
`paper` and the `fixed` range have it off.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import page_product, page_sum
from mossar_stream.memory.joint_pages import (
    LAST_X,
    LAST_Y,
    LAST_Z,
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
TURNED = -0.1  # correlation of successive displacements below which they are noise
FIRST = 0.05  # s, at the start of a stream, in which every movement may be noise
DOUBT = 0.5  # what is added to the estimate for each frame's share in it
SLOWEST = 0.1  # s, time constant of the smoothing
UNEVEN = 1.6  # a step in time so many times the usual one has lost frames; in it, motion may turn back
BRIEF, LONGEST = 0.03, 0.1  # s, steps that are even in any case (frames may come in bursts), and in no case
SHORTER, LONGER = 0.8, 1.04  # how the usual step follows: to where about one step in six is shorter


@inline_kernel
def calm_noise(h, body, displacement, dt):
    """Take a frame in, set `h.noise_floor`, and return the frame's path with the noise smoothed out of it.

    Args:
        h: Header of the row.
        body: Displacements of the joints, now, before, and smoothed; 0 where one is missing or back after a gap.
        displacement: m, path of all; repeated frames have none and say nothing.
        dt: s since the last frame, 0 for the first.

    Returns:
        Path of all joints, m.
    """
    h.noise_time += dt
    if displacement > 0.0 or dt <= 0.0:
        turned = _turned(h, body)
        if _is_even(h):
            _listen(h, turned, displacement)
        else:
            h.noise_squares = 0.0  # nothing can be compared with this displacement
        h.noise_time = 0.0
    if dt <= 0.0 or not _is_loud(h):
        h.noise_floor = 0.0
        h.noise_smooth = 0
        return displacement
    return _smooth(h, body, displacement, dt)


@inline_kernel
def _turned(h, body):
    """Return the correlation of the displacements with the last ones, and keep them."""
    product = squares = 0.0
    for first in range(0, h.lanes, PAGE):
        page = page_of(body, first)
        _turn(page)
        product += page_sum(page, WORK)
        squares += page_product(page, STEP, STEP)
    scale = np.sqrt(squares * h.noise_squares)
    h.noise_squares = squares
    return product / scale if scale > 0.0 else 0.0


@inline_kernel
def _is_even(h):
    """Tell whether the frame follows the last one without a loss, and learn how long that takes."""
    step = h.noise_time
    if step <= 0.0:
        return False
    if h.noise_step == 0.0 or step < h.noise_step:
        h.noise_step = max(step, SHORTER * h.noise_step)
    even = step <= min(LONGEST, max(BRIEF, UNEVEN * h.noise_step))
    h.noise_step = max(h.noise_step, min(step, LONGER * h.noise_step))
    return even


@inline_kernel
def _turn(page):
    for j in range(PAGE):
        x, y, z = page[j + MOVED_X], page[j + MOVED_Y], page[j + MOVED_Z]
        page[j + WORK] = x * page[j + LAST_X] + y * page[j + LAST_Y] + z * page[j + LAST_Z]
        page[j + LAST_X], page[j + LAST_Y], page[j + LAST_Z] = x, y, z


@inline_kernel
def _listen(h, turned, displacement):
    """Take the path of a frame for noise if joints keep turning back."""
    time = h.noise_time
    keep = MEMORY / (MEMORY + time)
    h.noise_span = keep * (h.noise_span + time)
    h.noise_path = keep * (h.noise_path + displacement)
    h.noise_turn = keep * (h.noise_turn + turned * time)
    h.noise_heard += time
    is_noise = h.noise_turn < TURNED * h.noise_span
    if is_noise:
        h.noise_known = 1
    if is_noise or (h.noise_known == 0 and h.noise_heard < FIRST):
        # The average of few frames may be too low.
        h.noise = h.noise_path / h.noise_span * (1.0 + DOUBT * time / h.noise_span)
    elif h.noise_known == 0:
        h.noise = 0.0


@inline_kernel
def _is_loud(h):
    """Tell whether the noise comes too near to the threshold line."""
    return h.noise * h.window * h.noise_margin > h.theta * max(h.largest, h.range_floor)


@kernel
def _smooth(h, body, displacement, dt):
    """Smooth the displacements as far as the noise calls for, set the floor for what is left, return the path.

    A weight of a for the newest displacement leaves a/√(2 - a) of the path of white noise.
    """
    noise = h.noise * h.window * h.noise_margin
    k = (h.theta * max(h.largest, h.range_floor) / noise) ** 2
    share = max(dt / (dt + SLOWEST), 0.5 * (np.sqrt(k * k + 8.0 * k) - k))
    h.noise_floor = noise * share / np.sqrt(2.0 - share) / h.theta
    # Smoothing begins from rest, for it is there that noise becomes known.
    keep = 1.0 - share if h.noise_smooth == 1 else 0.0
    h.noise_smooth = 1
    take = share if displacement > 0.0 else 0.0
    for first in range(0, h.lanes, PAGE):
        _follow(page_of(body, first), np.float32(keep), np.float32(take))
    raw, smooth = line_sum(h, body, STEP), line_sum(h, body, WORK)
    return smooth * displacement / raw if raw > 0.0 else smooth


@kernel
def _follow(page, keep, take):
    for j in range(PAGE):
        x = keep * page[j + SMOOTH_X] + take * page[j + LAST_X]
        y = keep * page[j + SMOOTH_Y] + take * page[j + LAST_Y]
        z = keep * page[j + SMOOTH_Z] + take * page[j + LAST_Z]
        page[j + SMOOTH_X], page[j + SMOOTH_Y], page[j + SMOOTH_Z] = x, y, z
        page[j + WORK] = np.sqrt(x * x + y * y + z * z)
