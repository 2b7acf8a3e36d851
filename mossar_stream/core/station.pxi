"""Station: the records by which Python tells the loop whose frames it has, and where everything lies."""

cdef enum:
    NO_ANALYSIS = 0  # in Channel.heed
    CHANGES = 1
    ALL_ANALYSES = 2

# Whether a frame causes events, 0 or 1, of: state and store of a reader, with their lengths in bytes, (J, 3) positions in m,
# the number of joints, and the time in s.
ctypedef int64_t (*See)(
    uint8_t* state, int64_t state_bytes, uint8_t* store, int64_t store_bytes, float* positions, int64_t joints, double time
) noexcept nogil


cdef struct Station:  # one performer; its channels follow, then its readers
    int64_t limbs
    int64_t readers
    int64_t phase  # whether the phase of each frame is asked for
    int64_t joints  # of all limbs together
    int64_t order  # where they begin, bytes: which joint of the performer each is, negative for the middle,
    int64_t frame  # and where each is in the frame that the body processed last, m


cdef struct Channel:  # the body's, then those of the limbs
    int64_t row  # address
    int64_t row_bytes
    int64_t first  # of its joints among those of all limbs; -1 of the body
    int64_t joints
    int64_t heed  # which analyses of its repetitions are to stop the loop
    int64_t is_taken  # whether the frame step took the last frame, and did not pass it over


cdef struct Reader:
    int64_t call  # address of the function, a `See`
    int64_t state  # address
    int64_t state_bytes
    int64_t store  # address
    int64_t store_bytes


cdef struct LoopHead:
    int64_t performers
    int64_t count  # frames of each; 0 for all there are
    int64_t performer  # which is next,
    int64_t frame  # how many of its frames are processed,
    int64_t stage  # and who is next with the frame: 0 the body, then limbs, readers, the phase
    int64_t stopped  # why the loop stopped, until that is done
    int64_t changed  # whether the last analysis of repetitions changed what is counted


cdef struct Seat:
    int64_t station  # address
    int64_t begin  # first of its frames


cdef struct Tools:
    int64_t scratch  # where it begins, bytes
    int64_t scratch_bytes
    int64_t store  # in which repetitions are analysed
    int64_t store_bytes
    int64_t events
    int64_t events_bytes
