"""Kernels of the similarity as tests call them, with arrays as in face.pxi."""


cdef inline FloatRows float_rows_of(cnp.ndarray rows):
    return floats_in_rows(<float*>cnp.PyArray_DATA(rows), cnp.PyArray_DIM(rows, 0), cnp.PyArray_DIM(rows, 1))


cdef inline Floats floats_of(cnp.ndarray line):
    return floats(<float*>cnp.PyArray_DATA(line), cnp.PyArray_DIM(line, 0))


def similarity_add_frame(
    params, summary, body, pose, int64_t joints, double time, double weight, int64_t moving, double speed
):
    cdef SummaryFrame frame = SummaryFrame(floats_of(body), float_rows_of(pose), joints, time, weight, moving, speed)
    add_frame(measure_of(params), doubles_of(summary), &frame)


def similarity_flush_sums(params, summary, body, int64_t padded_joints):
    flush_sums(measure_of(params), doubles_of(summary), floats_of(body), padded_joints)


def similarity_add_pose(params, summary, pose, int64_t joints, double time, double weight):
    add_pose(measure_of(params), doubles_of(summary), float_rows_of(pose), joints, time, weight)


def similarity_add_joint(params, summary, pose, int64_t joints, int64_t j):
    add_joint(measure_of(params), doubles_of(summary), float_rows_of(pose), joints, j)


def similarity_merge_into(params, target, other):
    merge_into(measure_of(params), doubles_of(target), doubles_of(other))


def similarity_close(params, summary):
    close(measure_of(params), doubles_of(summary))


def similarity_strength(params, left, right, both):
    return strength(measure_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_merge_cost(params, left, right, both):
    return merge_cost(measure_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_similarity(params, double cost, left, right):
    return similarity(measure_of(params), cost, doubles_of(left), doubles_of(right))


def similarity_write_features(params, summary, features):
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


def blocks_sum(near, link, inner, ends):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found = block_sum(&block)
    return found.total, found.down


def blocks_depth_first_sum(near, link, inner, ends):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found = depth_first_sum(&block)
    return found.total, found.down


def blocks_subset_sum(near, link, inner, ends):
    """Sum a block by subsets.

    Raises:
        ValueError: More groups of twins than are summed so.
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


def blocks_groups_of_twins(near, link, inner, ends):
    cdef Block block = block_of(near, link, inner, ends)
    cdef Twins twins
    find_twins(&block, &twins)
    return twins.count


def blocks_frontier_sum(near, link, inner, ends, cnp.ndarray order):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found
    if not frontier_sum(&block, <int64_t*>cnp.PyArray_DATA(order), &found):
        raise MemoryError
    return found.total, found.down


def blocks_elimination_order(near, cnp.ndarray order):
    """Set the order of settling; return its cost and the width of its frontier."""
    cdef Block block
    cdef int64_t v
    block.count = len(near)
    for v in range(block.count):
        block.near[v] = <uint64_t><int64_t>near[v]
    return elimination_order(&block, <int64_t*>cnp.PyArray_DATA(order))
