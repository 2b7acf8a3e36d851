"""Event buffer: through it compiled code hands events out.

`events.py` has the records that users see; out.pxi makes them.
"""

cdef enum:
    PATH_JOINTS = 5  # joints named as active in a segment
    NO_JOINT = -1  # in place of a joint; after it there is none either
    KEY_FRAME = 0
    SEGMENT = 1
    ACTIVITY_CHANGE = 2
    TAKE_START = 3
    KEY_CANDIDATE = 0
    KEY_WITHDRAWN = 1
    KEY_CONFIRMED = 2
    KEY_MERGED = 3
    KEY_RESTORED = 4
    KEY_FINAL = 5
    KIND_ONSET = 0
    KIND_OFFSET = 1
    KIND_MINIMUM = 2
    SEGMENT_CLOSED = 0
    SEGMENT_WITHDRAWN = 1
    SEGMENT_FINAL = 2
    FIRST_MESSAGE = 1  # about a key frame: revisions
    SECOND_MESSAGE = 2
    UNDECIDED = 0
    DECIDED = 1
cdef double UNKNOWN_STRENGTH = NAN

cdef struct Event:
    int64_t performer  # place of the performer among those that are processed together
    int64_t channel  # 0 of the body, then those of limbs
    int64_t code  # KEY_FRAME, SEGMENT, ACTIVITY_CHANGE or TAKE_START
    int64_t status  # index into KEY_FRAME_STATUSES or SEGMENT_STATUSES
    int64_t nature  # index into KEY_FRAME_KINDS, or into SEGMENT_STATES
    int64_t take
    int64_t rev
    int64_t id  # Algorithm 2's frame; of a segment the start's; of an activity its number
    int64_t end_id  # of a segment the end's
    int64_t frame
    int64_t until_frame  # decided_frame; of a segment end_frame
    int64_t decided
    double time  # of an activity its start
    double until_time  # decided_time; of a segment end_time
    double velocity
    double strength  # of a segment its similarity, of an activity `previous`; NaN for None
    double active_start  # of a segment; NaN for None
    double active_end
    int64_t joint0
    int64_t joint1
    int64_t joint2
    int64_t joint3
    int64_t joint4


cdef struct Point:  # A key frame in a message.
    int64_t kind  # KIND_ONSET, KIND_OFFSET or KIND_MINIMUM
    int64_t id  # Algorithm 2's frame
    int64_t frame  # its present place
    double time  # s
    double velocity  # share of the range
    double strength  # NaN where it is not known


cdef struct EventSpan:
    Event* at
    int64_t count  # that there is room for
    int64_t* used
    int64_t performer  # whose the next ones are


cdef Event* next_event(Clock* clock, EventSpan events, int64_t code) noexcept nogil:
    """Return a fresh record of the buffer for the performer and the take of a clock."""
    cdef Event* event = &events.at[events.used[0]]
    events.used[0] += 1
    event.performer, event.channel = events.performer, clock.channel
    event.code = code
    event.take = clock.take
    return event


cdef void put_key_frame(
    Clock* clock, EventSpan events, Point point, int64_t status, int64_t rev, int64_t decided
) noexcept nogil:
    """Put a message about a key frame, caused by the last used frame, into the buffer."""
    cdef Event* event
    event = next_event(clock, events, KEY_FRAME)
    event.status = status
    event.nature = point.kind
    event.id = point.id
    event.frame = point.frame
    event.time = point.time
    event.velocity = point.velocity
    event.strength = point.strength
    event.rev = rev
    event.decided = decided
    event.until_frame = clock.used_frame
    event.until_time = clock.time


cdef void put_start(Clock* clock, EventSpan events) noexcept nogil:
    """Put a message that a take has begun into the buffer."""
    next_event(clock, events, TAKE_START)


cdef inline void find_active(Doubles paths, uint64_t details, Ints active) noexcept nogil:
    """Set the joints with the longest paths, -1 where no more of them moved; of equal ones the first come first.

    Args:
        paths: (J,) m.
        details: A bit for each of the first 64 joints that does not count; see `mossar_stream.moves.joints.details`.
        active: (PATH_JOINTS,) is set.
    """
    cdef int64_t place, j, last
    cdef double least
    for place in range(PATH_JOINTS):
        active.at[place] = NO_JOINT
    least = 0.0
    for j in range(paths.count):
        if paths.at[j] > least and (j >= 64 or details >> <uint64_t>j & <uint64_t>1 == 0):
            place = PATH_JOINTS - 1
            while place > 0 and (active.at[place - 1] == NO_JOINT or paths.at[active.at[place - 1]] < paths.at[j]):
                active.at[place] = active.at[place - 1]
                place -= 1
            active.at[place] = j
            last = active.at[PATH_JOINTS - 1]
            least = paths.at[last] if last != NO_JOINT else 0.0
