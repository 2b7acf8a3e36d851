"""Face of the similarity: constants and functions for Python.

None of the functions is called for each frame: they compare whole recordings, for `Comparison`, and single graphs, for
checks. Arrays are contiguous.
"""

CONSTANTS.update({
    "AT_REST": AT_REST,
    "BIN_RATE": BIN_RATE,
    "CERTAIN": CERTAIN,
    "COINCIDENT": COINCIDENT,
    "DURATION": DURATION,
    "FEATURES": FEATURES,
    "FRAMES": FRAMES,
    "FRONTIER_SLOTS": FRONTIER_SLOTS,
    "LATEST": LATEST,
    "MOST_CHANGE": MOST_CHANGE,
    "MOST_EDGES": MOST_EDGES,
    "MOST_PROMINENT": MOST_PROMINENT,
    "MOVING_FRAMES": MOVING_FRAMES,
    "PATH": PATH,
    "PEAK_ABOVE_NOISE": PEAK_ABOVE_NOISE,
    "POSE_FLOOR": POSE_FLOOR,
    "PRECISION": PRECISION,
    "SHORTEST_SEGMENT": SHORTEST_SEGMENT,
    "SPEED_FLOOR": SPEED_FLOOR,
    "SPEED_FLOOR_OF_ODDS": SPEED_FLOOR_OF_ODDS,
    "STEP_BEFORE": STEP_BEFORE,
    "STILL": STILL,
    "TERM": TERM,
    "WEIGHTS": (
        WEIGHTS_CHANGE_OF_POSE,
        WEIGHTS_CHANGE_OF_SPEED,
        WEIGHTS_STOP,
        WEIGHTS_REST,
        WEIGHTS_REST_DISTANCE,
        WEIGHTS_BIAS,
    ),
})


cdef inline Measure* measure_of(cnp.ndarray params):
    return <Measure*>cnp.PyArray_DATA(params)


cdef inline DoubleRows double_rows_of(cnp.ndarray rows):
    return doubles_in_rows(<double*>cnp.PyArray_DATA(rows), rows.shape[0], rows.shape[1])


cdef inline Doubles doubles_of(cnp.ndarray line):
    return doubles(<double*>cnp.PyArray_DATA(line), line.shape[0])


def summarise_pieces(
    cnp.ndarray params, cnp.ndarray poses, cnp.ndarray times, cnp.ndarray starts, cnp.ndarray summaries,
    int64_t joints, /
):
    """Summarise the pieces of a recording; see `fill_pieces`.

    Args:
        params: (1,) MEASURE.
        poses: (n, 4, padded joints) float32 m relative to the centre.
        times: (n,) float64 s.
        starts: (pieces,) int64, first frame of each.
        summaries: (pieces, slot) float64, zero; set.
        joints: J.
    """
    cdef FloatPlanes planes
    planes.at = <float*>cnp.PyArray_DATA(poses)
    planes.planes, planes.rows, planes.columns = poses.shape[0], poses.shape[1], poses.shape[2]
    fill_pieces(
        measure_of(params), planes, <double*>cnp.PyArray_DATA(times), <int64_t*>cnp.PyArray_DATA(starts),
        double_rows_of(summaries), joints,
    )


def summarise_later(cnp.ndarray params, cnp.ndarray summaries, int64_t size, cnp.ndarray later, /):
    """Summarise so many pieces from each piece on; see `gather_pieces`.

    Args:
        params: (1,) MEASURE.
        summaries: (pieces, slot) float64.
        size: Pieces.
        later: (pieces, slot) float64, zero; set.
    """
    gather_pieces(measure_of(params), double_rows_of(summaries), size, double_rows_of(later))


def compare(
    cnp.ndarray params, cnp.ndarray summaries, cnp.ndarray later, bounds, cnp.ndarray scratch, cnp.ndarray found, /
):
    """Set the strengths at pieces; see `compare_pieces`.

    Args:
        params: (1,) MEASURE.
        summaries: (pieces, slot) float64.
        later: (pieces, slot) float64, of `summarise_later`.
        bounds: First piece, size of the later segment and the longest of the earlier ones, pieces.
        scratch: (3, slot) float64, zero.
        found: float64, set.
    """
    cdef int64_t first, size, longest
    first, size, longest = bounds
    compare_pieces(
        measure_of(params), double_rows_of(summaries), double_rows_of(later), first, size, longest,
        double_rows_of(scratch), doubles_of(found),
    )


def sum_of_paths(cnp.ndarray vertex_weights, cnp.ndarray edges, cnp.ndarray edge_weights, int64_t turns=1):
    """Compute `path_sum` so many times, and return it.

    Args:
        vertex_weights: (V,) float64.
        edges: (E, 2) int64.
        edge_weights: (E,) float64.
        turns: Number of computations.

    Raises:
        ValueError: More edges, or vertices, than are supported.
    """
    cdef Doubles on_vertices = doubles_of(vertex_weights), on_edges = doubles_of(edge_weights)
    cdef int64_t turn
    cdef double total = 0.0
    if on_edges.count > MOST_EDGES or on_vertices.count > MOST_JOINTS:
        raise ValueError(f"at most {MOST_EDGES} edges and {MOST_JOINTS} vertices are supported")
    for turn in range(turns):
        total = path_sum(
            on_vertices.at, on_vertices.count, <int64_t*>cnp.PyArray_DATA(edges), on_edges.at, on_edges.count
        )
    return total
