"""Face of recognised moves: what Python calls, and where it finds the parts of a store and of a memory.

A part is described by its offset in bytes, the name of its record or number type, and its shape.
"""

CONSTANTS.update({
    "CONFIRMED": CONFIRMED,
    "FINAL": FINAL,
    "WITHDRAWN": WITHDRAWN,
    "EXPLAINED": EXPLAINED,
    "MOST": MOST,
    "STRICT_WORTH": STRICT_WORTH,
    "LEAD_WORTH": LEAD_WORTH,
    "LEAD_COUNTED": LEAD_COUNTED,
    "SMOOTHED": SMOOTHED,
    "AVERAGED": AVERAGED,
    "ONSET": ONSET,
})


def address_of_recognise():
    """Return the address of the function that a reader of moves has."""
    return <size_t><void*>&recognise


def move_numbers(int64_t joints):
    """Return how many numbers a pose of so many joints takes: three for each, padded."""
    return padded_to_factors(3 * joints)


cdef MoveStore _move_head(int64_t joints, int64_t examples, int64_t moves):
    cdef MoveStore head
    memset(&head, 0, sizeof(MoveStore))
    head.joints, head.examples, head.moves = joints, examples, moves
    head.numbers = padded_to_factors(3 * joints)
    return head


def move_store_bytes(int64_t joints, int64_t examples, int64_t moves):
    """Return the bytes that examples of so many moves take, described for so many joints."""
    cdef MoveStore head
    head = _move_head(joints, examples, moves)
    return lay_out_move_store(NOWHERE, &head).end - NOWHERE


def move_memory_bytes(int64_t joints, int64_t moves):
    """Return the bytes that recognising takes for one performer, by the joints and moves of the examples."""
    cdef MoveStore head
    head = _move_head(joints, 0, moves)
    return open_move_memory(NOWHERE, &head).end - NOWHERE


def move_store_parts(uint8_t[::1] store):
    """Return the parts of a store whose head is written."""
    cdef MoveBank bank
    cdef uint8_t* begin
    begin = &store[0]
    bank = open_move_store(begin)
    return {
        "head": (0, "MoveStore", (1,)),
        "joints": (<uint8_t*>bank.joints - begin, "JointPair", (bank.head.joints,)),
        "limbs": (<uint8_t*>bank.limbs - begin, "int64", (bank.head.joints,)),
        "examples": (<uint8_t*>bank.examples - begin, "MoveExample", (bank.head.examples,)),
        "rules": (<uint8_t*>bank.rules - begin, "float64", (bank.head.moves, 2)),
    }


def move_memory_parts(int64_t joints, int64_t moves):
    """Return the parts of a performer's memory."""
    cdef MoveStore head
    cdef MoveMemory known
    head = _move_head(joints, 0, moves)
    known = open_move_memory(NOWHERE, &head)
    return {
        "state": (0, "RecognitionState", (1,)),
        "poses": (<uint8_t*>known.poses.at - NOWHERE, "float32", (known.poses.rows, known.poses.columns)),
        "last_times": (<uint8_t*>known.last_times - NOWHERE, "float64", (moves,)),
    }


def write_example(
    uint8_t[::1] store, int64_t t, int64_t move, float[:, ::1] poses, double[::1] path
):
    """Describe the whole of an example, number t; see `write_move_example`."""
    write_move_example(
        &store[0], t, move, floats_in_rows(&poses[0, 0], poses.shape[0], poses.shape[1]),
        doubles(&path[0], path.shape[0]),
    )


def compare_with_all(
    uint8_t[::1] store, float[:, ::1] poses, double[::1] path, double[::1] costs, double[::1] postures
):
    """Compare an example with each of those in a store; see `compare_move_with_all`."""
    compare_move_with_all(
        &store[0], floats_in_rows(&poses[0, 0], poses.shape[0], poses.shape[1]),
        doubles(&path[0], path.shape[0]), &costs[0], &postures[0],
    )


def mean_heading(float[:, :, ::1] positions, int64_t[::1] girdles):
    """Return the cosine and the sine of a movement's mean heading; no turn where there are no hips.

    Args:
        positions: (n, J, 3) m.
        girdles: (4,) left and right hip, left and right shoulder; -1 for none.
    """
    cdef FloatPlanes planes
    planes.at = &positions[0, 0, 0]
    planes.planes, planes.rows, planes.columns = positions.shape[0], positions.shape[1], positions.shape[2]
    return mean_heading_of(planes, &girdles[0])


cdef dict _move_records():
    """Return the numpy type of each record, as the compiler laid it out."""
    cdef JointPair joint_pair
    cdef MoveStore move_store
    cdef MoveExample move_example
    cdef RecognitionState recognition_state
    return {
        "JointPair": record_type(<JointPair[:1]>&joint_pair),
        "MoveStore": record_type(<MoveStore[:1]>&move_store),
        "MoveExample": record_type(<MoveExample[:1]>&move_example),
        "RecognitionState": record_type(<RecognitionState[:1]>&recognition_state),
    }


RECORDS.update(_move_records())
