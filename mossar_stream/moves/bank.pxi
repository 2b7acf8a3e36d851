"""The bank: all examples described for the joints of one stream, as the recogniser compares them."""


# ENTRY: called from Python
cdef void write_example(Bytes store, int64_t t, int64_t move, FloatRows poses, Doubles path) noexcept nogil:
    """Describe the whole of an example, number t; see `measure.describe`."""
    cdef MoveBank bank
    cdef int64_t at, d, k
    # CHECK call of open_store: open_store(store)
    bank = open_store(store)
    if t == 0:
        for d in range(bank.begin.count):
            bank.begin.at[d] = poses.at[d]
    measure_describe(poses, path, 0, path.count - 1, &bank)
    bank.examples.at[t].move = move
    bank.examples.at[t].size = bank.scratch.size.at[0]
    at = t * ROWS
    # Number by number: for whole rows numba compiles the words of errors, too, which takes seconds.
    for d in range(bank.rows.columns):
        for k in range(DIRECTIONS):
            bank.rows.at[(at + k) * bank.rows.columns + d] = bank.scratch.directions.at[k * bank.scratch.directions.columns + d]
        bank.rows.at[(at + DIRECTIONS) * bank.rows.columns + d] = bank.scratch.box.at[d]
        bank.rows.at[(at + DIRECTIONS + 1) * bank.rows.columns + d] = bank.scratch.shares.at[d]
        bank.rows.at[(at + DIRECTIONS + 2) * bank.rows.columns + d] = bank.scratch.stance.at[d]


# ENTRY: called from Python
cdef void compare_with_all(Bytes store, FloatRows poses, Doubles path, Doubles costs, Doubles postures) noexcept nogil:
    """Compare an example with each of those in a store.

    Args:
        store: See `make_store`.
        poses: (n, D) m of the example; see `example_poses`.
        path: (n,) m; see `path_of`.
        costs: (T,) float64, gets what it costs to take the example for each.
        postures: (T,) float64, gets the cosine of the two mean postures.
    """
    cdef MoveBank bank
    cdef int64_t t, at
    cdef Description* scratch
    cdef FloatRows rows
    cdef float factor
    # CHECK call of open_store: open_store(store)
    bank = open_store(store)
    scratch = &bank.scratch
    rows = bank.rows
    measure_describe(poses, path, 0, path.count - 1, &bank)
    for t in range(bank.examples.count):
        at = t * ROWS
        factor = correction(scratch, row_of_floats(rows, at + DIRECTIONS), row_of_floats(rows, at + DIRECTIONS + 1), bank.examples.at[t].size)
        factor *= strangeness(scratch, row_of_floats(rows, at + DIRECTIONS + 2))
        costs.at[t] = factor * warped(scratch, rows_of_floats(rows, at, at + DIRECTIONS), NEVER)
        postures.at[t] = line_product(scratch.stance.at, row_of_floats(rows, at + DIRECTIONS + 2).at)
