"""Leading principal components of the posture over the window, by two power iterations an analysis.

The window changes little between two analyses, so that two steps of the subspace iteration from the axes of the last analysis
are enough; the first analysis of a movement makes a few.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel
from mossar_stream.jit.simd import line_products, weighted_sums
from mossar_stream.repetitions.sampling import MEDIAN
from mossar_stream.repetitions.state import (
    COMPONENTS,
    LEAST_SAMPLES,
    RECENT,
    SAMPLES,
    ring_place,
    window_size,
)

SWING_ABOVE_NOISE = 2.56 * 1.1  # times the standard deviation of normal noise, with a margin
LAST = COMPONENTS - 1
SHARE = 0.3  # of the standard deviation of the movement, between samples
LEAST_SWING = 0.03  # of the size of the body, rms over joints: who stands may sway as far


@kernel
def find_components(header, samples, scratch):
    """Set axes and scores, in the order of time, for the samples in the window, and how far they must swing.

    Args:
        header: `HEADER` record.
        samples: `Samples`; axes of the last analysis are where to begin.
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
        _turn_axes(samples, n)
    _project(samples, n)
    _project_rest_pose(samples)
    scratch.least = max(header.least * np.sqrt(header.joints), LEAST_SWING * np.sqrt(header.size))
    scratch.least = max(scratch.least, _noise_swing(header, samples, n))
    fine = max(header.fine - (header.open - n), n - RECENT, 0)
    if n - fine >= LEAST_SAMPLES:
        header.step = SHARE**2 * _spread(samples, fine, n)
    return n


@kernel
def _lay_out(header, samples, n, oldest):
    """Set the coordinates of the window in the order of time, m, and 0 from there on."""
    until, quantum = min(n, SAMPLES - oldest), header.quantum
    for k in range(samples.pose.size):
        row, ring = samples.by_coordinate[k], samples.ring[k]
        _to_metres(row[:until], ring[oldest : oldest + until], quantum)
        _to_metres(row[until:n], ring[: n - until], quantum)
        rest = row[n:]
        for i in range(len(rest)):
            rest[i] = np.float32(0.0)
    for c in range(3):
        row, path = samples.by_coordinate[3 * header.root + c], samples.root[c]
        _copy(row[:until], path[oldest : oldest + until])
        _copy(row[until:n], path[: n - until])


@inline_kernel
def _to_metres(goal, quanta, quantum):
    # Over slices, as elsewhere: an index with an offset would be tested for its sign and not vectorise.
    for i in range(len(goal)):
        goal[i] = np.float32(quanta[i]) * quantum


@inline_kernel
def _copy(goal, numbers):
    for i in range(len(goal)):
        goal[i] = numbers[i]


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
    return SWING_ABOVE_NOISE * np.sqrt((header.joints + 1.0 + size / n) * variance)


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
    scores = samples.scores
    weighted_sums(scores, samples.axes, samples.by_coordinate, n)
    a = b = c = d = np.float32(0.0)  # `COMPONENTS` sums side by side
    for i in range(n):
        a += scores[0, i]
        b += scores[1, i]
        c += scores[2, i]
        d += scores[3, i]
    rest = samples.rest_pose_scores
    rest[0], rest[1], rest[2], rest[3] = -a, -b, -c, -d
    for k in range(COMPONENTS):
        rest[k] /= np.float32(n)
        row, mean = scores[k, :n], rest[k]
        for i in range(n):
            row[i] += mean


@kernel
def _project_rest_pose(samples):
    """Add to the scores of a pose of zeros what makes them those of the pose `rest_pose`."""
    axes, rest, scores = samples.axes, samples.rest_pose, samples.rest_pose_scores
    a, b, c, d = scores[0], scores[1], scores[2], scores[3]
    for j in range(rest.size):
        a += axes[0, j] * rest[j]
        b += axes[1, j] * rest[j]
        c += axes[2, j] * rest[j]
        d += axes[3, j] * rest[j]
    scores[0], scores[1], scores[2], scores[3] = a, b, c, d


@kernel
def _turn_axes(samples, n):
    """Multiply the axes by the covariance of the window and make them orthonormal again."""
    line_products(samples.axes, samples.scores, samples.by_coordinate, n)
    _orthonormalise(samples.axes)


@kernel
def _orthonormalise(axes):
    """Gram and Schmidt; an axis of which nothing is left becomes zero.

    Each axis is taken out of all that follow before the next one is: their products are independent sums.
    """
    size = axes.shape[1]
    for k in range(COMPONENTS):
        axis, square = axes[k], np.float32(0.0)
        for j in range(size):
            square += axis[j] * axis[j]
        scale = np.float32(0.0) if square < np.float32(1e-12) else np.float32(1.0) / np.sqrt(square)
        for j in range(size):
            axis[j] *= scale
        # The last ones again where there are fewer than three: a sum more costs nothing.
        one, two, three = axes[min(k + 1, LAST)], axes[min(k + 2, LAST)], axes[LAST]
        a = b = c = np.float32(0.0)
        for j in range(size):
            a += one[j] * axis[j]
            b += two[j] * axis[j]
            c += three[j] * axis[j]
        if k < LAST:
            _take_out(one, axis, a)
        if k + 1 < LAST:
            _take_out(two, axis, b)
        if k + 2 < LAST:
            _take_out(three, axis, c)


@inline_kernel
def _take_out(goal, axis, product):
    for j in range(len(goal)):
        goal[j] -= product * axis[j]


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
