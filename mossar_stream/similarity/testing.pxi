# Kernels of the similarity, for their tests; arrays as in face.pxi, `params` a MEASURE, summaries (slot,) float64.


cdef FloatRows float_rows_of(object array):
    return floats_in_rows(<float*>memory_of(array), array.shape[0], array.shape[1])


cdef Floats floats_of(object array):
    return floats(<float*>memory_of(array), array.shape[0])


def similarity_add_frame(params, summary, body, pose, int64_t joints, double time, double weight, int64_t moving, double speed):
    cdef SummaryFrame frame = SummaryFrame(floats_of(body), float_rows_of(pose), joints, time, weight, moving, speed)
    add_frame(<Measure*>memory_of(params), doubles_of(summary), &frame)


def similarity_flush_sums(params, summary, body, int64_t padded_joints):
    flush_sums(<Measure*>memory_of(params), doubles_of(summary), floats_of(body), padded_joints)


def similarity_add_pose(params, summary, pose, int64_t joints, double time, double weight):
    add_pose(<Measure*>memory_of(params), doubles_of(summary), float_rows_of(pose), joints, time, weight)


def similarity_add_joint(params, summary, pose, int64_t joints, int64_t j):
    add_joint(<Measure*>memory_of(params), doubles_of(summary), float_rows_of(pose), joints, j)


def similarity_merge_into(params, target, other):
    merge_into(<Measure*>memory_of(params), doubles_of(target), doubles_of(other))


def similarity_close(params, summary):
    close(<Measure*>memory_of(params), doubles_of(summary))


def similarity_strength(params, left, right, both):
    return strength(<Measure*>memory_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_merge_cost(params, left, right, both):
    return merge_cost(<Measure*>memory_of(params), doubles_of(left), doubles_of(right), doubles_of(both))


def similarity_similarity(params, double cost, left, right):
    return similarity(<Measure*>memory_of(params), cost, doubles_of(left), doubles_of(right))


def similarity_write_features(params, summary, features):
    """Write `Features`, given as a sequence in the order of the struct."""
    cdef Features own
    own.speed, own.rest_distance, own.extent, own.usual_speed, own.tempo, own.noise, own.joints = features
    write_features(<Measure*>memory_of(params), doubles_of(summary), own)


cdef Block block_of(object near, object link, object inner, object ends):
    """Return a block of numpy arrays."""
    cdef Block block
    cdef int64_t v, n = len(near)
    if n > MOST_VERTICES:
        raise ValueError(f"at most {MOST_VERTICES} vertices are supported")
    block.count = n
    for v in range(n):
        block.near[v], block.inner[v], block.ends[v] = <uint64_t><int64_t>near[v], inner[v], ends[v]
    memcpy(block.link, memory_of(link), n * n * sizeof(double))
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


def blocks_frontier_sum(near, link, inner, ends, order):
    cdef Block block = block_of(near, link, inner, ends)
    cdef BlockSum found
    if not frontier_sum(&block, <int64_t*>memory_of(order), &found):
        raise MemoryError
    return found.total, found.down


def blocks_elimination_order(near, order):
    """Set the order of settling; return its cost and the width of its frontier."""
    cdef Block block
    cdef int64_t v
    block.count = len(near)
    for v in range(block.count):
        block.near[v] = <uint64_t><int64_t>near[v]
    return elimination_order(&block, <int64_t*>memory_of(order))
