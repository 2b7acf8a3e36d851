"""Row: where one performer's state lives.

Everything that is remembered of one performer is one row of bytes: the records of all concepts (each declared beside
the functions that write it), then arrays whose sizes follow from the joints and the settings. A snapshot is a copy of
the row, a pool of performers is a matrix of rows, and nothing is allocated while frames come in. Compiled code looks
at a row through views; where the arrays begin stands in the record `at`, in bytes from the row's start.
"""

cdef enum:
    CACHE_LINE = 64  # bytes


cdef struct Places:  # where the arrays of a row begin, bytes from its start
    int64_t body  # positions and displacements of the joints, see joint_pages.pxi
    int64_t seen  # (padded_joints,) s, when each joint was last there; -inf if never
    int64_t tracked  # (padded_joints,) frames that bear out where each joint is, see joints.pxi
    int64_t filtered  # (6, padded_joints) m and m/s, One-Euro filter
    int64_t pose  # (4, padded_joints) last frame's features as one array, see joint_pages.flatten
    int64_t ring_time  # (ring,) s, ends of the displacements in the velocity window
    int64_t ring_step  # (ring,) 2^-40 m, those displacements summed over the joints
    int64_t average  # (smoothing_window,) 2^-40 m, velocities under the moving average
    int64_t summaries  # (slots, slot) summaries of segments, see summary.pxi
    int64_t unused  # (slots,) stack of unused slots
    int64_t order  # (W + 2,) slots of the window's segments, from left to right
    int64_t keys  # (W + 2,) undecided key frames, from left to right
    int64_t counts  # (W + 3, W + 2) messages sent about each segment of the window
    int64_t memo  # (memo,) merge costs computed before
    int64_t marks  # (history_size,) of the poses kept to take speeds from and to move key frames
    int64_t poses  # (history_size, 3, padded_joints) 1/8192 m, those poses
    int64_t bouts  # (bouts,) of movement, the latest that have ended
    int64_t notes  # (notes,) of the last candidates
    int64_t counted  # (1,) of repetitions, if they are counted here
    int64_t periods  # (1,) of it, by which candidates are judged
    int64_t samples  # of them, see repetitions/state.pxi
    int64_t adopted  # (1,) of a limb: what is counted of its body, by which its candidates are judged


cdef struct Row:
    Plan plan
    Clock clock
    Counters counters
    JointsState joints
    Noise noise
    Velocity velocity
    Average average
    Range range
    Curve curve
    OpenSegmentState open_segment
    Slots slots
    History history
    Tempo tempo
    Scales scales
    Dwells dwells
    Labels labels
    Candidate candidate
    ActivityState activity
    WindowState window
    Places at


cdef inline Floats body_of(Row* row) noexcept nogil:
    """Return the body; see joint_pages.pxi."""
    return floats(<float*>(<uint8_t*>row + row.at.body), (row.at.seen - row.at.body) // 4)


cdef inline PoseHistory history_of(Row* row) noexcept nogil:
    """Return the poses of the last seconds."""
    cdef PoseHistory history
    history.state = &row.history
    history.marks.at, history.marks.count = <Mark*>(<uint8_t*>row + row.at.marks), row.plan.history_size
    history.poses.at = <int16_t*>(<uint8_t*>row + row.at.poses)
    history.poses.planes, history.poses.rows, history.poses.columns = row.plan.history_size, 3, row.plan.padded_joints
    history.body = body_of(row)
    return history


cdef inline Activity activity_of(Row* row) noexcept nogil:
    """Return whether the performer moves."""
    cdef Activity activity
    activity.state = &row.activity
    activity.bouts.at, activity.bouts.count = <Bout*>(<uint8_t*>row + row.at.bouts), row.plan.bouts
    return activity


cdef inline OpenSegment open_segment_of(Row* row, Measure* params) noexcept nogil:
    """Return what came since the last key frame."""
    cdef uint8_t* begin = <uint8_t*>row
    cdef OpenSegment segment
    segment.plan = &row.plan
    segment.state = &row.open_segment
    segment.slots = &row.slots
    segment.params = params
    segment.unused = ints(<int64_t*>(begin + row.at.unused), row.plan.slot_count)
    segment.summaries = doubles_in_rows(<double*>(begin + row.at.summaries), row.plan.slot_count, row.plan.slot)
    segment.body = body_of(row)
    segment.pose = floats_in_rows(<float*>(begin + row.at.pose), 4, row.plan.padded_joints)
    return segment
