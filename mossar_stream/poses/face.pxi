"""Face of held poses: functions for Python, and the places of the parts of a bank and of a memory.

A part is described by its offset in bytes, the name of its record or number type, and its shape.
"""

CONSTANTS.update({
    "POSE_UNCHANGED": POSE_UNCHANGED,
})


def pose_bank_bytes(int64_t points, int64_t bones, int64_t poses, /):
    """Return the bytes of a bank."""
    cdef PosesHead head
    memset(&head, 0, sizeof(PosesHead))
    head.points, head.bones, head.poses = points, bones, poses
    return lay_out_pose_bank(NOWHERE, &head).end - NOWHERE


def pose_bank_parts(cnp.ndarray store, /):
    """Return the parts of a bank whose head is written."""
    cdef PoseBank bank
    cdef PosesHead* head
    cdef uint8_t* begin
    begin = <uint8_t*>cnp.PyArray_DATA(store)
    bank = open_pose_bank(begin)
    head = bank.head
    return {
        "head": (0, "PosesHead", (1,)),
        "points": (<uint8_t*>bank.points - begin, "JointPair", (head.points,)),
        "bones": (<uint8_t*>bank.bones - begin, "Bone", (head.bones,)),
        "shown": (<uint8_t*>bank.shown - begin, "ShownPose", (head.poses,)),
        "rows": (<uint8_t*>bank.rows.at - begin, "float64", (head.poses, head.bones, 3)),
    }


def pose_memory_bytes(cnp.ndarray store, /):
    """Return the bytes that a performer takes."""
    return open_pose_memory(NOWHERE, <PosesHead*>cnp.PyArray_DATA(store)).end - NOWHERE


def pose_memory_parts(cnp.ndarray store, /):
    """Return the parts of a performer's memory."""
    cdef PosesHead* head
    cdef PoseMemory known
    head = <PosesHead*>cnp.PyArray_DATA(store)
    known = open_pose_memory(NOWHERE, head)
    return {
        "state": (0, "HoldingState", (1,)),
        "fast": (<uint8_t*>known.fast.at - NOWHERE, "float64", (head.bones, 3)),
        "slow": (<uint8_t*>known.slow.at - NOWHERE, "float64", (head.bones, 3)),
        "strays": (<uint8_t*>known.strays.at - NOWHERE, "float64", (head.bones,)),
        "chords": (<uint8_t*>known.chords.at - NOWHERE, "float64", (head.bones,)),
    }


RECORDS.update(record_types(MOSSAR_RECORDS.decode(), {
    "PosesHead": sizeof(PosesHead),
    "ShownPose": sizeof(ShownPose),
    "HoldingState": sizeof(HoldingState),
}))
