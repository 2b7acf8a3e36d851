"""Pyramid: the Temporal Pyramid Covariance of a segment's joints, from sums that merge (paper 2.2.1).

Layer l of the pyramid cuts the segment into l equal parts; for each part a joint has the 6 upper elements of the
covariance of its coordinates, so that L layers give it a vector of 6 (1 + 2 + … + L) numbers.

With one layer a single bin of sums describes the segment. With more, at most 64 bins of equal length do: powers of
two of 1/256 s on the source's clock, doubled in length when 64 no longer reach. Which bins there are thus follows
from the first and the last time alone, and it does not matter in which order segments were merged. A bin belongs
to the part that its middle lies in: borders of parts are right to 1/64 of the segment's length.

A bin holds the weight (s), for each joint the mean of its coordinates and, as in Chan, Golub and LeVeque (1979),
the weighted sum of products of their deviations from the mean. Raw sums of squares would leave rounding noise on
joints that hardly move, which the cosine of two covariances blows up.

Every function takes the parameters of `kernel.make_params` and summaries as described there.
"""

import numpy as np
from numba import float64, int64, void

from mossar_stream.jit.decorators import kernel
from mossar_stream.jit.linked import linked
from mossar_stream.memory.joint_pages import PADDING
from mossar_stream.similarity.summary import DURATION

MOST_BINS = 64
BIN_RATE = 256.0  # Hz, of the shortest bins
LATEST = 1e12  # s; clocks are cut off there
MOST_LEVELS = 48  # of doubling, after which a bin holds everything
CLOCK_LEVEL, CLOCK_FIRST, CLOCK_LAST = range(3)  # log2 of the bins' length, numbers of the first and last one
FIRST_PLACE = np.int64(0)  # of the bins


def bin_size(padded_joints: int) -> int:
    """Return the length of a bin: weight and padding, 3 means and 6 products per joint."""
    return PADDING + 9 * padded_joints


@kernel
def add_moments(params, summary, pose, time, weight):
    """Add a pose to the bin of its time, before it is added to the summary's duration.

    Args:
        params: Record.
        summary: Summary.
        pose: (4, padded joints), of which 3 rows are coordinates, m.
        time: s, not before that of the poses added so far.
        weight: s, > 0.
    """
    place = _place(params, summary, time) if params.bins > 1 else FIRST_PLACE
    at = params.bins_at + place * params.bin_size
    _mix(
        summary[at : at + params.bin_size],
        pose[:3].reshape(3 * params.padded_joints),
        params.padded_joints,
        weight,
    )


@kernel
def rest_in_moments(params, summary, pose, j):
    """Let a joint have rest where it is for as long as a summary lasts."""
    padded_joints = params.padded_joints
    for place in range(params.bins):
        at = params.bins_at + place * params.bin_size
        if summary[at] > 0.0:
            at += PADDING + j
            for d in range(9):
                summary[at + d * padded_joints] = pose[d, j] if d < 3 else np.float32(0.0)


@kernel
def _place(params, summary, time):
    """Return the place of the bin for a time; bins are doubled in length until there is one."""
    clock = summary[params.clock_at : params.clock_at + 3]
    number = np.int64(np.floor(min(max(time, -LATEST), LATEST) * BIN_RATE))
    if summary[DURATION] == 0.0:
        clock[CLOCK_LEVEL], clock[CLOCK_FIRST], clock[CLOCK_LAST] = 0.0, number, number
        return FIRST_PLACE
    number = max(number >> np.int64(clock[CLOCK_LEVEL]), np.int64(clock[CLOCK_FIRST]))
    while number - np.int64(clock[CLOCK_FIRST]) >= params.bins:
        _coarsen(summary, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
        number >>= 1
    clock[CLOCK_LAST] = max(clock[CLOCK_LAST], number)
    return number - np.int64(clock[CLOCK_FIRST])


@kernel
def _mix(own, means, padded_joints, weight):
    """Add other means with their weight to a bin: weight, means, and what their difference adds to the products."""
    own[0] += weight
    share = weight / own[0]
    pull = (own[0] - weight) * share
    delta = np.empty(3 * padded_joints)
    center = own[PADDING : PADDING + 3 * padded_joints]
    for d in range(3 * padded_joints):
        delta[d] = means[d] - center[d]
        center[d] += share * delta[d]
    at = PADDING + 3 * padded_joints
    for a in range(3):
        for b in range(a, 3):
            one, two = (
                delta[a * padded_joints : (a + 1) * padded_joints],
                delta[b * padded_joints : (b + 1) * padded_joints],
            )
            products = own[at : at + padded_joints]
            for j in range(padded_joints):
                products[j] += pull * one[j] * two[j]
            at += padded_joints


@kernel
def _merge_bin(own, other, padded_joints):
    """Add one bin to another one, which may be empty."""
    if other[0] > 0.0:
        _mix(own, other[PADDING : PADDING + 3 * padded_joints], padded_joints, other[0])
        for d in range(PADDING + 3 * padded_joints, PADDING + 9 * padded_joints):
            own[d] += other[d]


@linked("mossar.coarsen", void(float64[::1], int64, int64, int64, int64))
def _coarsen(summary, clock_at, bins_at, size, padded_joints):
    """Double the length of the bins."""
    first, last = np.int64(summary[clock_at + CLOCK_FIRST]), np.int64(summary[clock_at + CLOCK_LAST])
    for number in range(first, last + 1):
        source, target = number - first, (number >> 1) - (first >> 1)
        if source != target:
            _move_bin(summary, bins_at, size, padded_joints, source, target)
    summary[clock_at + CLOCK_LEVEL] += 1.0
    summary[clock_at + CLOCK_FIRST], summary[clock_at + CLOCK_LAST] = first >> 1, last >> 1


@kernel
def _move_bin(summary, bins_at, size, padded_joints, source, target):
    """Add a bin to another one of the same summary and leave it empty."""
    old = summary[bins_at + source * size : bins_at + (source + 1) * size]
    new = summary[bins_at + target * size : bins_at + (target + 1) * size]
    _merge_bin(new, old, padded_joints)
    for d in range(size):
        old[d] = 0.0


@kernel
def merge_moments(params, target, other):
    """Add the bins of a neighbouring segment, earlier or later; neither summary is empty."""
    mine = target[params.clock_at : params.clock_at + 3]
    theirs = other[params.clock_at : params.clock_at + 3]
    while mine[CLOCK_LEVEL] < theirs[CLOCK_LEVEL]:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
    shift = np.int64(mine[CLOCK_LEVEL] - theirs[CLOCK_LEVEL])
    first, last = np.int64(theirs[CLOCK_FIRST]), np.int64(theirs[CLOCK_LAST])
    while max(mine[CLOCK_LAST], last >> shift) - min(mine[CLOCK_FIRST], first >> shift) >= params.bins:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.padded_joints)
        shift += 1
    ahead = np.int64(mine[CLOCK_FIRST]) - (first >> shift)
    if ahead > 0:
        for place in range(np.int64(mine[CLOCK_LAST] - mine[CLOCK_FIRST]), -1, -1):
            _move_bin(target, params.bins_at, params.bin_size, params.padded_joints, place, place + ahead)
        mine[CLOCK_FIRST] = first >> shift
    mine[CLOCK_LAST] = max(mine[CLOCK_LAST], last >> shift)
    size = params.bin_size
    for number in range(first, last + 1):
        to = params.bins_at + ((number >> shift) - np.int64(mine[CLOCK_FIRST])) * size
        source = params.bins_at + (number - first) * size
        _merge_bin(target[to : to + size], other[source : source + size], params.padded_joints)


@kernel
def set_covariances(params, summary):
    """Set the pyramid of every joint; a part without a frame has no covariance, so 0."""
    whole = np.empty(params.bin_size)
    clock = summary[params.clock_at : params.clock_at + 3]
    count = np.int64(clock[CLOCK_LAST] - clock[CLOCK_FIRST]) + 1
    padded_joints, size = params.padded_joints, params.bin_size
    at = params.covariances_at
    for layer in range(1, params.layers + 1):
        for part in range(layer):
            for d in range(size):
                whole[d] = 0.0
            for place in range(count):
                if (2 * place + 1) * layer // (2 * count) == part:
                    start = params.bins_at + place * size
                    _merge_bin(whole, summary[start : start + size], padded_joints)
            scale = 1.0 / whole[0] if whole[0] > 0.0 else 0.0
            for j in range(params.joints):
                for element in range(6):
                    own = whole[PADDING + (3 + element) * padded_joints + j] * scale
                    if element == 0 or element == 3 or element == 5:  # noqa: PLR1714 - a tuple compiles slowly
                        own += params.diagonal
                    summary[at + j * params.covariance + element] = own
            at += 6
