"""Leading principal components of the posture over the window, by two power iterations a look.

The window changes little between two looks, so that two steps of the subspace iteration from the axes of the last look
are enough; the first look at a movement makes a few.
"""

import numpy as np

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.simd import line_product
from mossar_stream.repetitions.sampling import MEDIAN
from mossar_stream.repetitions.state import (
    COMPONENTS,
    LEAST_SAMPLES,
    RECENT,
    SAMPLES,
    ring_place,
    window_size,
)

STANDS_OUT = 2.56 * 1.1  # times the standard deviation of normal noise, with a margin
SHARE = 0.3  # of the standard deviation of the movement, between samples
LEAST_SWING = 0.03  # of the size of the body, rms over joints: who stands may sway as far


@kernel
def find_components(header, samples, scratch):
    """Set axes and scores, in the order of time, for the samples in the window, and how far they must swing.

    Args:
        header: `HEADER` record.
        samples: `Samples`; axes of the last look are where to begin.
        scratch: `SCRATCH` record.

    Returns:
        How many samples there are.
    """
    n = window_size(header)
    oldest = ring_place(header, n, 0)
    _lay_out(header, samples, n, oldest)
    lost = _begin_axes(samples, n)
    for _ in range(4 if lost else 2):
        _project(samples, n)
        _turn_axes(samples)
    _project(samples, n)
    for k in range(COMPONENTS):
        for j in range(samples.pose.size):
            samples.home_scores[k] += samples.axes[k, j] * samples.home[j]
    scratch.least = max(header.least * np.sqrt(header.joints), LEAST_SWING * np.sqrt(header.size))
    scratch.least = max(scratch.least, _noise_swing(header, samples, n))
    fine = max(header.fine - (header.open - n), n - RECENT, 0)
    if n - fine >= LEAST_SAMPLES:
        header.step = SHARE**2 * _spread(samples, fine, n)
    return n


@kernel
def _lay_out(header, samples, n, oldest):
    """Set the coordinates of the window in the order of time, m, and 0 from there on."""
    until = min(n, SAMPLES - oldest)
    for k in range(samples.pose.size):
        row, ring = samples.by_coordinate[k], samples.ring[k]
        for i in range(until):
            row[i] = np.float32(ring[oldest + i]) * header.quantum
        for i in range(until, n):
            row[i] = np.float32(ring[i - until]) * header.quantum
        for i in range(n, SAMPLES):
            row[i] = np.float32(0.0)
    for c in range(3):
        row, path = samples.by_coordinate[3 * header.root + c], samples.root[c]
        for i in range(n):
            row[i] = path[(oldest + i) % SAMPLES]


@kernel
def _spread(samples, begin, n):
    """Return the variance of the scores from a sample on, added up, m²."""
    total, count = 0.0, n - begin
    for k in range(COMPONENTS):
        row, squares, mean = samples.scores[k], np.float32(0.0), np.float32(0.0)
        for i in range(begin, n):
            mean += row[i]
            squares += row[i] * row[i]
        total += float(squares) - float(mean) ** 2 / count
    return total / count


@kernel
def _noise_swing(header, samples, n):
    """Return how far the scores of noise alone may swing, from the 10th to the 90th percentile.

    Half of what is known of it is the root's, which is in all J joints alike, and gives its components J times the
    variance of a coordinate's noise; n samples of D coordinates show D / n more.
    """
    size = samples.pose.size
    variance = 0.5 * MEDIAN * header.noise / size
    return STANDS_OUT * np.sqrt((header.joints + 1.0 + size / n) * variance)


@kernel
def _begin_axes(samples, n):
    """Let axes that are zero, as before a take and while nobody moves, begin with the departures at four times.

    Returns:
        Whether the first was among them.
    """
    begun = -1
    for k in range(COMPONENTS - 1, -1, -1):
        if _is_zero(samples.axes[k]):
            begun = k
            i = (k + 1) * (n - 1) // COMPONENTS
            for j in range(samples.pose.size):
                samples.axes[k, j] = samples.by_coordinate[j, i] - samples.by_coordinate[j, 0]
    if begun >= 0:
        _orthonormalise(samples.axes)
    return begun == 0


@kernel
def _is_zero(axis):
    """Return whether nothing is left of an axis; otherwise its first numbers tell."""
    j = 0
    while j < axis.size and axis[j] == 0:
        j += 1
    return j == axis.size


@kernel
def _project(samples, n):
    """Set the centred scores of the window, and of a pose of zeros."""
    for k in range(COMPONENTS):
        row = samples.scores[k]
        row[:] = np.float32(0.0)
        axis = samples.axes[k]
        for j in range(0, samples.pose.size, 3):  # a joint at a time is quicker
            a, b, c = axis[j], axis[j + 1], axis[j + 2]
            x, y, z = samples.by_coordinate[j], samples.by_coordinate[j + 1], samples.by_coordinate[j + 2]
            for i in range(n):
                row[i] = row[i] + a * x[i] + b * y[i] + c * z[i]
        total = np.float32(0.0)
        for i in range(n):
            total += row[i]
        total /= np.float32(n)
        for i in range(n):
            row[i] -= total
        samples.home_scores[k] = -total


@kernel
def _turn_axes(samples):
    """Multiply the axes by the covariance of the window and make them orthonormal again."""
    for k in range(COMPONENTS):
        for j in range(samples.pose.size):
            samples.axes[k, j] = line_product(samples.scores[k], samples.by_coordinate[j])
    _orthonormalise(samples.axes)


@kernel
def _orthonormalise(axes):
    """Gram and Schmidt; an axis of which nothing is left becomes zero."""
    for k in range(COMPONENTS):
        for other in range(k):
            product = np.float32(0.0)
            for j in range(axes.shape[1]):
                product += axes[k, j] * axes[other, j]
            for j in range(axes.shape[1]):
                axes[k, j] -= product * axes[other, j]
        square = np.float32(0.0)
        for j in range(axes.shape[1]):
            square += axes[k, j] * axes[k, j]
        scale = np.float32(0.0) if square < np.float32(1e-12) else np.float32(1.0) / np.sqrt(square)
        for j in range(axes.shape[1]):
            axes[k, j] *= scale


@kernel
def smooth_scores(samples, n, width):
    """Set `samples.smooth` to the means over a centred window of the scores, shorter at the ends.

    Args:
        samples: `Samples`.
        n: How many there are, at least `width`.
        width: Samples, odd.
    """
    half = width // 2
    share = np.float32(1.0) / np.float32(width)
    for k in range(COMPONENTS):
        row, out = samples.scores[k], samples.smooth[k]
        for i in range(n):
            out[i] = row[i]
        for apart in range(1, half + 1):
            for i in range(n - apart):
                out[i] += row[i + apart]
            for i in range(apart, n):
                out[i] += row[i - apart]
        for i in range(n):
            out[i] *= share
        for i in range(half):
            fewer = np.float32(width) / np.float32(i + half + 1)
            out[i] *= fewer
            out[n - 1 - i] *= fewer
