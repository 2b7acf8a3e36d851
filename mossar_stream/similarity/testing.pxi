"""Kernels of the similarity for tests, with arrays as in face.pxi."""


import numpy as np


cdef inline FloatRows float_rows_of(cnp.ndarray rows):
    return floats_in_rows(<float*>cnp.PyArray_DATA(rows), rows.shape[0], rows.shape[1])


cdef inline Floats floats_of(cnp.ndarray line):
    return floats(<float*>cnp.PyArray_DATA(line), line.shape[0])


def similarity_add_frame(
    params, summary, body, pose, int64_t joints, double time, double weight, int64_t moving, double speed, /
):
    cdef SummaryFrame frame
    frame = SummaryFrame(floats_of(body), float_rows_of(pose), joints, time, weight, moving, speed)
    add_frame(measure_of(params), doubles_of(summary), &frame)


def similarity_flush_sums(params, summary, body, int64_t padded_joints, /):
    flush_sums(measure_of(params), doubles_of(summary), floats_of(body), padded_joints)


def similarity_add_pose(params, summary, pose, int64_t joints, double time, double weight, /):
    add_pose(measure_of(params), doubles_of(summary), float_rows_of(pose), joints, time, weight)


def similarity_add_joint(params, summary, pose, int64_t joints, int64_t j, /):
    add_joint(measure_of(params), doubles_of(summary), float_rows_of(pose), joints, j)


def similarity_merge_into(params, target, other, /):
    merge_into(measure_of(params), doubles_of(target), doubles_of(other))


def similarity_close(params, summary, /):
    close(measure_of(params), doubles_of(summary))


def similarity_strength(params, left, right, both, /):
    return strength(measure_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_merge_cost(params, left, right, both, /):
    return merge_cost(measure_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_similarity(params, double cost, left, right, /):
    return similarity(measure_of(params), cost, doubles_of(left), doubles_of(right))


def similarity_write_features(params, summary, features, /):
    """Write `Features`, given as a sequence in the order of the struct."""
    cdef Features own
    own.speed, own.rest_distance, own.extent, own.usual_speed, own.tempo, own.noise, own.joints = features
    write_features(measure_of(params), doubles_of(summary), own)


cdef Block block_of(near, cnp.ndarray link, inner, ends):
    """Return a block of numpy arrays."""
    cdef Block block
    cdef int64_t v, n = len(near)
    if n > MOST_VERTICES:
        raise ValueError(f"at most {MOST_VERTICES} vertices are supported")
    block.count = n
    for v in range(n):
        block.near[v], block.inner[v], block.ends[v] = <uint64_t><int64_t>near[v], inner[v], ends[v]
    memcpy(block.link, cnp.PyArray_DATA(link), n * n * sizeof(double))
    return block


def blocks_sum(near, link, inner, ends, /):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found = block_sum(&block)
    return found.total, found.down


def blocks_depth_first_sum(near, link, inner, ends, /):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found = depth_first_sum(&block)
    return found.total, found.down


def blocks_subset_sum(near, link, inner, ends, /):
    """Sum a block by subsets.

    Raises:
        ValueError: More groups of twins than this method supports.
    """
    cdef Block block = block_of(near, link, inner, ends)
    cdef Twins twins
    cdef BlockSum found
    find_twins(&block, &twins)
    if twins.states > MOST_STATES:
        raise ValueError(f"{twins.states} states")
    cdef void* room = malloc(subset_room(&twins))
    if room == NULL:
        raise MemoryError
    found = subset_sum(&block, &twins, room)
    free(room)
    return found.total, found.down


def blocks_groups_of_twins(near, link, inner, ends, /):
    cdef Block block = block_of(near, link, inner, ends)
    cdef Twins twins
    find_twins(&block, &twins)
    return twins.count


def blocks_frontier_sum(near, link, inner, ends, cnp.ndarray order, /):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found
    if not frontier_sum(&block, <int64_t*>cnp.PyArray_DATA(order), &found):
        raise MemoryError
    return found.total, found.down


def blocks_elimination_order(near, cnp.ndarray order, /):
    """Set the order of settling; return its cost and the width of its frontier."""
    cdef Block block
    cdef int64_t v
    block.count = len(near)
    for v in range(block.count):
        block.near[v] = <uint64_t><int64_t>near[v]
    return elimination_order(&block, <int64_t*>cnp.PyArray_DATA(order))


def similarity_remerge(
    cnp.ndarray params, cnp.ndarray segments, cnp.ndarray bounds, cnp.ndarray costs, cnp.ndarray strengths,
    cnp.ndarray removed, /
):
    """Run Algorithm 3 on K key frames with an empty memo and no cycle anywhere.

    Args:
        params: (1,) MEASURE.
        segments: (K + 1, slot) float64 summaries, closed.
        bounds: (K + 2,) int64.
        costs: (K,) float64, set.
        strengths: (K,) float64, set.
        removed: (K,) int64, set.
    """
    cdef int64_t count = bounds.shape[0] - 2
    cdef cnp.ndarray integers = np.zeros((8, count + 1), np.int64)
    cdef cnp.ndarray nodes = np.empty_like(segments), both = np.empty(segments.shape[1])
    cdef IntRows rows = ints_in_rows(<int64_t*>cnp.PyArray_DATA(integers), 8, count + 1)
    cdef Remerging run
    integers[0] = range(count + 1)
    memset(&run, 0, sizeof(run))
    run.params, run.segments = measure_of(params), double_rows_of(segments)
    run.nodes, run.both = double_rows_of(nodes), doubles_of(both)
    run.places, run.bounds = row_of_ints(rows, 0), ints(<int64_t*>cnp.PyArray_DATA(bounds), count + 2)
    run.before, run.after = row_of_ints(rows, 1).at, row_of_ints(rows, 2).at
    run.node, run.waiting = row_of_ints(rows, 3).at, row_of_ints(rows, 4).at
    run.last_waiting = row_of_ints(rows, 5).at
    run.costs, run.strengths = doubles_of(costs), doubles_of(strengths)
    run.removed, run.labels = ints(<int64_t*>cnp.PyArray_DATA(removed), count), row_of_ints(rows, 6)
    run.tree = row_of_ints(rows, 7)
    remerge(&run, count, 1.0)
