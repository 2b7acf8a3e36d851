"""Face of recognised moves: functions for Python, and the places of the parts of a store and of a memory.

A part is described by its offset in bytes, the name of its record or number type, and its shape.
"""

CONSTANTS.update({
    "MOST": MOST,
    "STRICT_WORTH": STRICT_WORTH,
    "LEAD_WORTH": LEAD_WORTH,
    "LEAD_COUNTED": LEAD_COUNTED,
    "SMOOTHED": SMOOTHED,
    "AVERAGED": AVERAGED,
    "ONSET": ONSET,
})


def move_numbers(int64_t joints, /):
    """Return the number of coordinates of a pose with so many joints: three for each, padded."""
    return padded_to_factors(3 * joints)


cdef MoveStore _move_head(int64_t joints, int64_t examples, int64_t moves):
    cdef MoveStore head
    memset(&head, 0, sizeof(MoveStore))
    head.joints, head.examples, head.moves = joints, examples, moves
    head.numbers = padded_to_factors(3 * joints)
    return head


def move_store_bytes(int64_t joints, int64_t examples, int64_t moves, /):
    """Return the bytes that examples of so many moves take, described for so many joints."""
    cdef MoveStore head
    head = _move_head(joints, examples, moves)
    return lay_out_move_store(NOWHERE, &head).end - NOWHERE


def move_memory_bytes(int64_t joints, int64_t moves, /):
    """Return the bytes that recognising takes for one performer, by the joints and moves of the examples."""
    cdef MoveStore head
    head = _move_head(joints, 0, moves)
    return open_move_memory(NOWHERE, &head).end - NOWHERE


def move_store_parts(cnp.ndarray store, /):
    """Return the parts of a store whose head is written."""
    cdef MoveBank bank
    cdef uint8_t* begin
    begin = <uint8_t*>cnp.PyArray_DATA(store)
    bank = open_move_store(begin)
    return {
        "head": (0, "MoveStore", (1,)),
        "joints": (<uint8_t*>bank.joints - begin, "JointPair", (bank.head.joints,)),
        "limbs": (<uint8_t*>bank.limbs - begin, "int64", (bank.head.joints,)),
        "examples": (<uint8_t*>bank.examples - begin, "MoveExample", (bank.head.examples,)),
        "rules": (<uint8_t*>bank.rules - begin, "float64", (bank.head.moves, 2)),
    }


def move_memory_parts(int64_t joints, int64_t moves, /):
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


def write_example(cnp.ndarray store, int64_t t, int64_t move, cnp.ndarray poses, cnp.ndarray path, /):
    """Describe the whole of an example, number t; see `write_move_example`.

    Args:
        store: Bytes.
        t: Its number.
        move: Its move's.
        poses: (n, numbers) float32.
        path: (n,) float64 m.
    """
    write_move_example(
        <uint8_t*>cnp.PyArray_DATA(store), t, move, _poses_in(poses),
        doubles(<double*>cnp.PyArray_DATA(path), cnp.PyArray_DIM(path, 0)),
    )


def compare_with_all(
    cnp.ndarray store, cnp.ndarray poses, cnp.ndarray path, cnp.ndarray costs, cnp.ndarray postures, /
):
    """Compare an example with each of those in a store; see `compare_move_with_all`.

    Args:
        store: Bytes.
        poses: (n, numbers) float32.
        path: (n,) float64 m.
        costs: (examples,) float64, set.
        postures: Likewise.
    """
    compare_move_with_all(
        <uint8_t*>cnp.PyArray_DATA(store), _poses_in(poses),
        doubles(<double*>cnp.PyArray_DATA(path), cnp.PyArray_DIM(path, 0)),
        <double*>cnp.PyArray_DATA(costs), <double*>cnp.PyArray_DATA(postures),
    )


def mean_heading(cnp.ndarray positions, cnp.ndarray girdles, /):
    """Return the cosine and the sine of a movement's mean heading; no turn where there are no hips.

    Args:
        positions: (n, J, 3) float32 m.
        girdles: (4,) int64: left and right hip, left and right shoulder; -1 for none.
    """
    cdef FloatPlanes planes
    planes.at = <float*>cnp.PyArray_DATA(positions)
    planes.planes, planes.rows = cnp.PyArray_DIM(positions, 0), cnp.PyArray_DIM(positions, 1)
    planes.columns = cnp.PyArray_DIM(positions, 2)
    return mean_heading_of(planes, <int64_t*>cnp.PyArray_DATA(girdles))


cdef FloatRows _poses_in(cnp.ndarray poses):
    return floats_in_rows(<float*>cnp.PyArray_DATA(poses), cnp.PyArray_DIM(poses, 0), cnp.PyArray_DIM(poses, 1))


RECORDS.update(record_types(MOSSAR_RECORDS.decode(), {
    "JointPair": sizeof(JointPair),
    "MoveStore": sizeof(MoveStore),
    "MoveExample": sizeof(MoveExample),
    "RecognitionState": sizeof(RecognitionState),
}))
