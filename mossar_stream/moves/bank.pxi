"""The bank: all examples described for the joints of one stream, as the recogniser compares them."""


cdef void write_move_example(
    uint8_t* store, int64_t t, int64_t move, FloatRows poses, Doubles path
) noexcept nogil:
    """Describe the whole of an example, number t; see `describe_stretch`."""
    cdef MoveBank bank
    cdef Description* found
    cdef int64_t line
    bank = open_move_store(store)
    found = &bank.scratch
    line = bank.head.numbers * sizeof(float)
    if t == 0:
        memcpy(bank.begin, poses.at, line)
    describe_stretch(poses, path, 0, path.count - 1, bank.head.joints, bank.head.girdles, found)
    bank.examples[t].move = move
    bank.examples[t].size = found.size[0]
    memcpy(row_of_example(&bank, t, 0), found.directions.at, DIRECTIONS * line)
    memcpy(row_of_example(&bank, t, DIRECTIONS), found.box.at, line)
    memcpy(row_of_example(&bank, t, DIRECTIONS + 1), found.shares.at, line)
    memcpy(row_of_example(&bank, t, DIRECTIONS + 2), found.stance.at, line)


cdef void compare_move_with_all(
    uint8_t* store, FloatRows poses, Doubles path, double* costs, double* postures
) noexcept nogil:
    """Compare an example with each of those in a store.

    Args:
        store: Of the examples.
        poses: (n, D) m of the example.
        path: (n,) m, length of the path up to each pose.
        costs: (T,) gets the cost of taking the example for each.
        postures: (T,) gets the cosine of the two mean postures.
    """
    cdef MoveBank bank
    cdef float factor
    cdef int64_t t
    bank = open_move_store(store)
    describe_stretch(poses, path, 0, path.count - 1, bank.head.joints, bank.head.girdles, &bank.scratch)
    for t in range(bank.head.examples):
        factor = _correction_of(&bank, t)
        factor *= _posture_of(&bank, t)
        costs[t] = factor * warped(&bank.scratch, directions_of_example(&bank, t), NEVER)
        postures[t] = line_product(
            bank.scratch.stance.at, row_of_example(&bank, t, DIRECTIONS + 2), bank.head.numbers
        )
