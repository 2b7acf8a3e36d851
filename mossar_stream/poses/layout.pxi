"""Layout: how the bytes of shown poses, and of a performer who may hold them, are laid out."""

cdef enum:
    POSES_HEAD_BYTES = 80
    SHOWN_BYTES = 16
    HOLDING_STATE_BYTES = 128

cdef struct PosesHead:
    int64_t points
    int64_t bones
    int64_t groups  # limbs that have bones; bones of none are one, too
    int64_t poses
    int64_t axis  # that points upwards
    double sign
    int64_t girdles[4]  # points of hips and shoulders, left before right; -1 for as shown


cdef struct ShownPose:
    int64_t name  # number of its name; s
    double hold  # number of its name; s


cdef struct HoldingState:
    double due  # s, when the next sample is due; see readers.py
    int64_t frames  # sampled since the last gap
    double time  # s, of the last sample
    double facing[2]  # x and z, smoothed
    int64_t near  # pose that the performer is near to, -1 for none
    double since  # s, from when on
    int64_t active  # pose that is held, -1 for none
    int64_t latest  # the one that is held or was last, of which start, seen, matched, number and rev are
    int64_t is_held  # whether that was reported
    double start  # s
    double seen  # s, when it was last held
    int64_t matched  # samples since its start
    int64_t number  # of the latest pose of the take
    int64_t rev
    int64_t happened  # at the last frame


cdef struct PoseBank:  # Shown poses, described for a stream.
    PosesHeadSpan head  # (1,) POSES_HEAD
    BonePointSpan points  # (K,) BONE_POINT
    BoneSpan bones  # (B,) BONE; `limb` is the number of a group
    ShownPoseSpan shown  # (P,) SHOWN
    DoublePlanes rows  # (P, B, 3) directions


cdef struct PoseMemory:  # What is known of a performer.
    HoldingStateSpan state  # (1,) HOLDING_STATE
    DoubleRows fast  # (B, 3) directions, averaged over `SMOOTHED`
    DoubleRows slow  # (B, 3) the same over `SETTLED`
    Doubles strays  # (B,) squares of the chord to the pose that is held, summed over samples
    Doubles chords  # (B,) the same of the pose that is looked at, now
    DoubleRows groups  # (2, G) mean of those over each limb, and how many bones it has
    FloatRows pose  # (K, 3) m, points of the last sample relative to the centre, y upwards


# NOT COMPILED IN ANY RUN: open_bank
# def open_bank(store):
#     """Return the bank that a store holds."""
#     head = part(store, 0, POSES_HEAD, (1,))
#     points, bones, poses = head[0].points, head[0].bones, head[0].poses
#     at_bones = POSES_HEAD_BYTES + points * BONE_POINT_BYTES
#     at_shown = at_bones + bones * BONE_BYTES
#     return Bank(
#         head,
#         part(store, POSES_HEAD_BYTES, BONE_POINT, (points,)),
#         part(store, at_bones, BONE, (bones,)),
#         part(store, at_shown, SHOWN, (poses,)),
#         part(store, at_shown + poses * SHOWN_BYTES, np.float64, (poses, bones, 3)),
#     )


# NOT COMPILED IN ANY RUN: open_memory
# def open_memory(memory, head):
#     """Return what is known of a performer."""
#     points, bones, groups = head.points, head.bones, head.groups
#     at_slow = HOLDING_STATE_BYTES + 8 * 3 * bones
#     at_strays = at_slow + 8 * 3 * bones
#     at_groups = at_strays + 8 * 2 * bones
#     return Memory(
#         part(memory, 0, HOLDING_STATE, (1,)),
#         part(memory, HOLDING_STATE_BYTES, np.float64, (bones, 3)),
#         part(memory, at_slow, np.float64, (bones, 3)),
#         part(memory, at_strays, np.float64, (bones,)),
#         part(memory, at_strays + 8 * bones, np.float64, (bones,)),
#         part(memory, at_groups, np.float64, (2, groups)),
#         part(memory, at_groups + 8 * 2 * groups, np.float32, (points, 3)),
#     )
