# What Python calls of the similarity, with numpy arrays of the types that the kernels name, C-contiguous. None of it is
# called while frames come: `Comparison` and the checks look at whole recordings.

WEIGHTS = (
    WEIGHTS_CHANGE_OF_POSE, WEIGHTS_CHANGE_OF_SPEED, WEIGHTS_STOP, WEIGHTS_REST, WEIGHTS_REST_DISTANCE, WEIGHTS_BIAS,
)


cdef inline void* memory_of(object array) except? NULL:
    """Return where an array's numbers begin."""
    return <void*><size_t>array.ctypes.data


cdef DoubleRows double_rows_of(object array):
    return doubles_in_rows(<double*>memory_of(array), array.shape[0], array.shape[1])


cdef Doubles doubles_of(object array):
    return doubles(<double*>memory_of(array), array.shape[0])


def summarise_pieces(params, poses, times, starts, summaries, int64_t joints):
    """Summarise the pieces of a recording: `fill_pieces`; params are a MEASURE."""
    cdef FloatPlanes planes
    planes.at = <float*>memory_of(poses)
    planes.planes, planes.rows, planes.columns = poses.shape
    fill_pieces(
        <Measure*>memory_of(params), planes, <double*>memory_of(times), <int64_t*>memory_of(starts),
        double_rows_of(summaries), joints,
    )


def summarise_later(params, summaries, int64_t size, later):
    """Summarise so many pieces from each piece on: `gather_pieces`."""
    gather_pieces(<Measure*>memory_of(params), double_rows_of(summaries), size, double_rows_of(later))


def compare(params, summaries, later, bounds, scratch, found):
    """Set the strengths at pieces: `compare_pieces`; bounds are the first piece, the size and the longest."""
    cdef int64_t first, size, longest
    first, size, longest = bounds
    compare_pieces(
        <Measure*>memory_of(params), double_rows_of(summaries), double_rows_of(later), first, size, longest,
        double_rows_of(scratch), doubles_of(found),
    )


def sum_of_paths(vertex_weights, edges, edge_weights, int64_t turns=1):
    """Return `path_sum`, computed so many times.

    Raises:
        ValueError: More than MOST_EDGES edges, or MOST_JOINTS vertices.
    """
    cdef const double* on_vertices = <double*>memory_of(vertex_weights)
    cdef const double* on_edges = <double*>memory_of(edge_weights)
    cdef const int64_t* pairs = <int64_t*>memory_of(edges)
    cdef int64_t turn, vertices = len(vertex_weights), count = len(edges)
    cdef double total = 0.0
    if count > MOST_EDGES or vertices > MOST_JOINTS:
        raise ValueError(f"at most {MOST_EDGES} edges and {MOST_JOINTS} vertices are supported")
    for turn in range(turns):
        total = path_sum(on_vertices, vertices, pairs, on_edges, count)
    return total
