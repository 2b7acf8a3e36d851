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

from mossar_stream.compiled import compiled

MEMORY = 0.15  # s, time constant of the averages
TURNED = -0.1  # correlation of successive displacements below which they are noise
FIRST = 0.05  # s, at the start of a stream, in which every movement may be noise
DOUBT = 0.5  # what is added to the estimate for each frame's share in it
SLOWEST = 0.1  # s, time constant of the smoothing


@compiled
def calm_noise(h, body, past, step, displacement, dt):
    """Take a frame in, set `h.noise_floor`, and return the frame's path with the noise smoothed out of it.

    Args:
        h: Header of the row.
        body: (3, lanes) m, the joints.
        past: (9, lanes) m: the joints in the frame before, their last displacements, and these smoothed.
        step: (lanes,) m, path of each joint in this frame.
        displacement: m, path of all; repeated frames have none and say nothing.
        dt: s since the last frame, 0 for the first.

    Returns:
        Path of all joints, m.
    """
    turned = _compare(h, body, past, step, displacement > 0.0 or dt <= 0.0)
    h.noise_time += dt
    if displacement > 0.0 and h.noise_time > 0.0:
        _listen(h, turned, displacement)
    if dt <= 0.0 or not _is_loud(h):
        h.noise_floor = 0.0
        h.noise_smooth = 0
        return displacement
    return _smooth(h, past, step, displacement, dt)


@compiled
def _compare(h, body, past, step, fresh):
    """Set this frame's displacements and return their correlation with the last ones."""
    cx = cy = cz = 0.0
    for j in range(h.joints):
        if h.center < 0 or j == h.center:
            cx += body[0, j] - past[0, j]
            cy += body[1, j] - past[1, j]
            cz += body[2, j] - past[2, j]
    if h.center < 0:
        cx, cy, cz = cx / h.joints, cy / h.joints, cz / h.joints
    square = last = turned = 0.0
    for j in range(h.joints):
        # Joints that are missing, or back after a gap, have no path.
        there = 1.0 if step[j] > 0.0 else 0.0
        x = there * (body[0, j] - past[0, j] - cx)
        y = there * (body[1, j] - past[1, j] - cy)
        z = there * (body[2, j] - past[2, j] - cz)
        past[0, j], past[1, j], past[2, j] = body[0, j], body[1, j], body[2, j]
        if fresh:
            square += x * x + y * y + z * z
            last += past[3, j] ** 2 + past[4, j] ** 2 + past[5, j] ** 2
            turned += x * past[3, j] + y * past[4, j] + z * past[5, j]
            past[3, j], past[4, j], past[5, j] = x, y, z
    scale = np.sqrt(square * last)
    return turned / scale if scale > 0.0 else 0.0


@compiled
def _listen(h, turned, displacement):
    """Take the path of a frame for noise if joints keep turning back."""
    keep = MEMORY / (MEMORY + h.noise_time)
    h.noise_span = keep * (h.noise_span + h.noise_time)
    h.noise_path = keep * (h.noise_path + displacement)
    h.noise_turn = keep * (h.noise_turn + turned * h.noise_time)
    # The average of few frames may be too low.
    mean = h.noise_path / h.noise_span * (1.0 + DOUBT * h.noise_time / h.noise_span)
    h.noise_heard += h.noise_time
    h.noise_time = 0.0
    if h.noise_turn < TURNED * h.noise_span:
        h.noise_known = 1
        h.noise = mean
    elif h.noise_known == 0:
        h.noise = mean if h.noise_heard < FIRST else 0.0


@compiled
def _is_loud(h):
    """Tell whether the noise comes too near to the threshold line."""
    return h.noise * h.window * h.noise_margin > h.theta * max(h.largest, h.range_floor)


@compiled
def _smooth(h, past, step, displacement, dt):
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
    raw = smooth = 0.0
    for j in range(h.joints):
        x = keep * past[6, j] + take * past[3, j]
        y = keep * past[7, j] + take * past[4, j]
        z = keep * past[8, j] + take * past[5, j]
        past[6, j], past[7, j], past[8, j] = x, y, z
        smooth += np.sqrt(x * x + y * y + z * z)
        raw += step[j]
    return smooth * displacement / raw if raw > 0.0 else smooth
