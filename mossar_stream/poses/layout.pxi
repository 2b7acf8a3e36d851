"""Layout: the bytes of shown poses, and of a performer who may hold them.

Only this file states the places of the parts of a store and of a performer's memory; Python asks for them.
"""

cdef struct PosesHead:  # The head of a bank; its arrays follow.
    int64_t points  # K
    int64_t bones  # B
    int64_t groups  # G, limbs that have bones; bones of none are one, too
    int64_t poses  # P
    int64_t axis  # that points upwards
    double sign
    int64_t girdles[4]  # points of hips and shoulders, left before right; -1 for as shown


cdef struct ShownPose:
    int64_t name  # number of its name
    double hold  # s


cdef struct HoldingState:
    double due  # s, when the next sample is due; see core/reader.pxi
    int64_t frames  # sampled since the last gap
    double time  # s, of the last sample
    double facing[2]  # x and z, smoothed
    int64_t near  # pose that the performer is near to, -1 for none
    double since  # s, begin of that
    int64_t active  # pose that is held, -1 for none
    int64_t latest  # the held or last one, the subject of start, seen, matched, number and rev
    int64_t is_held  # whether that was reported
    double start  # s
    double seen  # s, when it was last held
    int64_t matched  # samples since its start
    int64_t number  # of the latest pose of the take
    int64_t rev
    int64_t happened  # at the last frame


cdef struct PoseBank:  # The parts of a bank: shown poses, described for a stream.
    PosesHead* head
    JointPair* points  # (K,) the centre first
    Bone* bones  # (B,) `limb` is the number of a group
    ShownPose* shown  # (P,)
    DoublePlanes rows  # (P, B, 3) directions
    uint8_t* end


cdef struct PoseMemory:  # The parts of a performer's memory.
    HoldingState* state
    DoubleRows fast  # (B, 3) directions, averaged over `POSE_SMOOTHED`
    DoubleRows slow  # (B, 3) the same over `POSE_SETTLED`
    Doubles strays  # (B,) squares of the chord to the pose that is held, summed over samples
    Doubles chords  # (B,) the same of the compared pose, in this sample
    DoubleRows groups  # (2, G) mean of those over each limb, and its number of bones
    FloatRows pose  # (K, 3) m, points of the last sample relative to the centre, y upwards
    uint8_t* end


cdef inline PoseBank open_pose_bank(uint8_t* store) noexcept nogil:
    """Return the parts of a bank."""
    return lay_out_pose_bank(store, <PosesHead*>store)


cdef PoseBank lay_out_pose_bank(uint8_t* store, PosesHead* head) noexcept nogil:
    """Return the parts of a bank with this head, without reading it."""
    cdef PoseBank bank
    bank.head = head
    bank.points = <JointPair*>(store + sizeof(PosesHead))
    bank.bones = <Bone*>(bank.points + head.points)
    bank.shown = <ShownPose*>(bank.bones + head.bones)
    bank.rows.at = <double*>(bank.shown + head.poses)
    bank.rows.planes, bank.rows.rows, bank.rows.columns = head.poses, head.bones, 3
    bank.end = <uint8_t*>(bank.rows.at + head.poses * head.bones * 3)
    return bank


cdef PoseMemory open_pose_memory(uint8_t* memory, PosesHead* head) noexcept nogil:
    """Return the parts of a performer's memory, without reading it."""
    cdef PoseMemory known
    cdef int64_t bones
    bones = head.bones
    known.state = <HoldingState*>memory
    known.fast = doubles_in_rows(<double*>(memory + sizeof(HoldingState)), bones, 3)
    known.slow = doubles_in_rows(known.fast.at + 3 * bones, bones, 3)
    known.strays = doubles(known.slow.at + 3 * bones, bones)
    known.chords = doubles(known.strays.at + bones, bones)
    known.groups = doubles_in_rows(known.chords.at + bones, 2, head.groups)
    known.pose = floats_in_rows(<float*>(known.groups.at + 2 * head.groups), head.points, 3)
    known.end = <uint8_t*>(known.pose.at + 3 * head.points)
    return known
