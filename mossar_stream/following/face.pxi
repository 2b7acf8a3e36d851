"""Face of followed moves: functions for Python, and the places of the parts of a bank and of a memory.

A part is described by its offset in bytes, the name of its record or number type, and its shape.
"""

CONSTANTS.update({
    "PERIOD": PERIOD,
    "MOST_PHASES": MOST_PHASES,
    "LAYERS": LAYERS,
    "CAP": CAP,
})


def follow_bank_bytes(int64_t points, int64_t bones, cnp.ndarray phases, /):
    """Return the bytes of a bank, by the (n,) int64 phases of each example."""
    cdef FollowHead head
    cdef int64_t* counts = <int64_t*>cnp.PyArray_DATA(phases)
    cdef int64_t t, numbers
    memset(&head, 0, sizeof(FollowHead))
    head.points, head.bones, head.examples = points, bones, cnp.PyArray_DIM(phases, 0)
    numbers = 3 * points + head.examples * bones
    for t in range(head.examples):
        numbers += floats_of_followed(counts[t], bones)
    return <uint8_t*>(lay_out_follow_bank(NOWHERE, &head).floats + numbers) - NOWHERE


def place_follow_examples(cnp.ndarray store, /):
    """Note where things of examples lie; the head's counts and the `phases` of examples are there already."""
    cdef FollowBank bank
    bank = open_follow_bank(<uint8_t*>cnp.PyArray_DATA(store))
    place_examples(&bank)


def follow_bank_parts(cnp.ndarray store, /):
    """Return the parts of a bank; those behind the examples only once the examples are placed."""
    cdef FollowBank bank
    cdef FollowHead* head
    cdef uint8_t* begin
    begin = <uint8_t*>cnp.PyArray_DATA(store)
    bank = open_follow_bank(begin)
    head = bank.head
    return {
        "head": (0, "FollowHead", (1,)),
        "points": (<uint8_t*>bank.points - begin, "JointPair", (head.points,)),
        "bones": (<uint8_t*>bank.bones - begin, "Bone", (head.bones,)),
        "examples": (<uint8_t*>bank.examples - begin, "FollowedExample", (head.examples,)),
        "first_pose": (<uint8_t*>bank.floats - begin, "float32", (head.points, 3)),
        "weights": (<uint8_t*>weights_of_bones(&bank).at - begin, "float32", (head.examples, head.bones)),
    }


def follow_example_parts(cnp.ndarray store, int64_t t, /):
    """Return where the directions of an example and their means lie in a bank."""
    cdef FollowBank bank
    cdef FollowedExample* example
    cdef uint8_t* begin
    begin = <uint8_t*>cnp.PyArray_DATA(store)
    bank = open_follow_bank(begin)
    example = &bank.examples[t]
    return {
        "directions": (
            <uint8_t*>directions_of_followed(&bank, example).at - begin, "float32",
            (bank.head.bones, 3, example.padded),
        ),
        "means": (<uint8_t*>means_of_followed(&bank, example).at - begin, "float32", (bank.head.bones, 3)),
    }


def follow_memory_bytes(cnp.ndarray store, /):
    """Return the bytes that following takes for one performer."""
    cdef FollowBank bank
    bank = open_follow_bank(<uint8_t*>cnp.PyArray_DATA(store))
    return follow_memory_size(&bank)


def follow_memory_parts(cnp.ndarray store, /):
    """Return the parts of a performer's memory, but for cells."""
    cdef FollowHead* head
    cdef FollowMemory known
    head = <FollowHead*>cnp.PyArray_DATA(store)
    known = open_follow_memory(NOWHERE, head)
    return {
        "state": (0, "FollowingState", (1,)),
        "periods": (<uint8_t*>known.periods - NOWHERE, "Periods", (1,)),
        "moves": (<uint8_t*>known.moves - NOWHERE, "FollowedMove", (head.moves,)),
        "happened": (<uint8_t*>known.happened - NOWHERE, "int64", (head.moves,)),
        "reports": (<uint8_t*>known.reports.at - NOWHERE, "float64", (head.moves, known.reports.columns)),
        "boxes": (<uint8_t*>known.boxes - NOWHERE, "float32", (head.moves, 2, head.bones, 3)),
        "rings": (<uint8_t*>known.rings - NOWHERE, "float32", (head.strides, head.ring, head.bones, 3)),
    }


def follow_cell_parts(cnp.ndarray store, int64_t t, /):
    """Return where the cells of an example lie in a performer's memory."""
    cdef FollowBank bank
    cdef Cells cells
    bank = open_follow_bank(<uint8_t*>cnp.PyArray_DATA(store))
    cells = open_cells(NOWHERE, &bank.examples[t])
    return {
        "costs": (<uint8_t*>cells.costs.at - NOWHERE, "float32", (LAYERS, cells.costs.columns)),
        "steps": (<uint8_t*>cells.steps.at - NOWHERE, "uint8", (cells.steps.rows, cells.steps.columns)),
    }


RECORDS.update(record_types(MOSSAR_RECORDS.decode(), {
    "FollowHead": sizeof(FollowHead),
    "Bone": sizeof(Bone),
    "FollowedExample": sizeof(FollowedExample),
    "FollowedMove": sizeof(FollowedMove),
    "FollowReport": sizeof(FollowReport),
    "FollowingState": sizeof(FollowingState),
}))
