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

Every function takes the parameters of `path_kernel.make_params` and summaries as described there.
"""

import numpy as np
from numba import float64, int64, void

from mossar_stream.jit.decorators import compiled
from mossar_stream.jit.linked import apart
from mossar_stream.memory.joint_pages import PADDING
from mossar_stream.similarity.summary import DURATION

MOST_BINS = 64
BIN_RATE = 256.0  # Hz, of the shortest bins
LATEST = 1e12  # s; clocks are cut off there
MOST_LEVELS = 48  # of doubling, after which a bin holds everything
LEVEL, FIRST, LAST = range(3)  # in the clock: log2 of the bins' length, numbers of the first and last one
NONE = np.int64(0)


def bin_size(lanes: int) -> int:
    """Return the length of a bin: weight and padding, 3 means and 6 products per joint."""
    return PADDING + 9 * lanes


@compiled
def add_moments(params, slot, pose, time, weight):
    """Add a pose to the bin of its time, before it is added to the slot's duration.

    Args:
        params: Record.
        slot: Summary.
        pose: (4, lanes), of which 3 rows are coordinates, m.
        time: s, not before that of the poses added so far.
        weight: s, > 0.
    """
    place = _place(params, slot, time) if params.bins > 1 else NONE
    at = params.bins_at + place * params.bin_size
    _mix(slot[at : at + params.bin_size], pose[:3].reshape(3 * params.lanes), params.lanes, weight)


@compiled
def _place(params, slot, time):
    """Return the place of the bin for a time; bins are doubled in length until there is one."""
    clock = slot[params.clock_at : params.clock_at + 3]
    number = np.int64(np.floor(min(max(time, -LATEST), LATEST) * BIN_RATE))
    if slot[DURATION] == 0.0:
        clock[LEVEL], clock[FIRST], clock[LAST] = 0.0, number, number
        return NONE
    number = max(number >> np.int64(clock[LEVEL]), np.int64(clock[FIRST]))
    while number - np.int64(clock[FIRST]) >= params.bins:
        _coarsen(slot, params.clock_at, params.bins_at, params.bin_size, params.lanes)
        number >>= 1
    clock[LAST] = max(clock[LAST], number)
    return number - np.int64(clock[FIRST])


@compiled
def _mix(own, means, lanes, weight):
    """Add other means with their weight to a bin: weight, means, and what their difference adds to the products."""
    own[0] += weight
    share = weight / own[0]
    pull = (own[0] - weight) * share
    delta = np.empty(3 * lanes)
    center = own[PADDING : PADDING + 3 * lanes]
    for d in range(3 * lanes):
        delta[d] = means[d] - center[d]
        center[d] += share * delta[d]
    at = PADDING + 3 * lanes
    for a in range(3):
        for b in range(a, 3):
            one, two = delta[a * lanes : (a + 1) * lanes], delta[b * lanes : (b + 1) * lanes]
            products = own[at : at + lanes]
            for j in range(lanes):
                products[j] += pull * one[j] * two[j]
            at += lanes


@compiled
def _merge_bin(own, other, lanes):
    """Add one bin to another one, which may be empty."""
    if other[0] > 0.0:
        _mix(own, other[PADDING : PADDING + 3 * lanes], lanes, other[0])
        for d in range(PADDING + 3 * lanes, PADDING + 9 * lanes):
            own[d] += other[d]


@apart("mossar.coarsen", void(float64[::1], int64, int64, int64, int64))
def _coarsen(slot, clock_at, bins_at, size, lanes):
    """Double the length of the bins."""
    first, last = np.int64(slot[clock_at + FIRST]), np.int64(slot[clock_at + LAST])
    for number in range(first, last + 1):
        source, target = number - first, (number >> 1) - (first >> 1)
        if source != target:
            _move_bin(slot, bins_at, size, lanes, source, target)
    slot[clock_at + LEVEL] += 1.0
    slot[clock_at + FIRST], slot[clock_at + LAST] = first >> 1, last >> 1


@compiled
def _move_bin(slot, bins_at, size, lanes, source, target):
    """Add a bin to another one of the same summary and leave it empty."""
    old = slot[bins_at + source * size : bins_at + (source + 1) * size]
    new = slot[bins_at + target * size : bins_at + (target + 1) * size]
    _merge_bin(new, old, lanes)
    for d in range(size):
        old[d] = 0.0


@compiled
def merge_moments(params, target, other):
    """Add the bins of a neighbouring segment, earlier or later; neither summary is empty."""
    mine = target[params.clock_at : params.clock_at + 3]
    theirs = other[params.clock_at : params.clock_at + 3]
    while mine[LEVEL] < theirs[LEVEL]:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.lanes)
    shift = np.int64(mine[LEVEL] - theirs[LEVEL])
    first, last = np.int64(theirs[FIRST]), np.int64(theirs[LAST])
    while max(mine[LAST], last >> shift) - min(mine[FIRST], first >> shift) >= params.bins:
        _coarsen(target, params.clock_at, params.bins_at, params.bin_size, params.lanes)
        shift += 1
    ahead = np.int64(mine[FIRST]) - (first >> shift)
    if ahead > 0:
        for place in range(np.int64(mine[LAST] - mine[FIRST]), -1, -1):
            _move_bin(target, params.bins_at, params.bin_size, params.lanes, place, place + ahead)
        mine[FIRST] = first >> shift
    mine[LAST] = max(mine[LAST], last >> shift)
    size = params.bin_size
    for number in range(first, last + 1):
        to = params.bins_at + ((number >> shift) - np.int64(mine[FIRST])) * size
        source = params.bins_at + (number - first) * size
        _merge_bin(target[to : to + size], other[source : source + size], params.lanes)


@compiled
def set_covariances(params, slot):
    """Set the pyramid of every joint; a part without a frame has no covariance, so 0."""
    whole = np.empty(params.bin_size)
    clock = slot[params.clock_at : params.clock_at + 3]
    count = np.int64(clock[LAST] - clock[FIRST]) + 1
    lanes, size = params.lanes, params.bin_size
    at = params.covariances_at
    for layer in range(1, params.layers + 1):
        for part in range(layer):
            for d in range(size):
                whole[d] = 0.0
            for place in range(count):
                if (2 * place + 1) * layer // (2 * count) == part:
                    start = params.bins_at + place * size
                    _merge_bin(whole, slot[start : start + size], lanes)
            scale = 1.0 / whole[0] if whole[0] > 0.0 else 0.0
            for j in range(params.joints):
                for element in range(6):
                    own = whole[PADDING + (3 + element) * lanes + j] * scale
                    if element == 0 or element == 3 or element == 5:  # noqa: PLR1714 - a tuple compiles slowly
                        own += params.diagonal
                    slot[at + j * params.covariance + element] = own
            at += 6
