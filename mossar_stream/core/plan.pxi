"""Plan: sizes and settings of one performer, constant while frames come in; plan.py sets them."""

cdef enum:
    SPARE_SLOTS = 6  # beside those of undecided key frames: a segment more, the one before, three of the open one, one to spare
    MORE_ROOM = 4  # undecided key frames for which a row grows

cdef struct Plan:  # constant while frames come in, except the sizes of a row that grows
    # Sizes.
    int64_t joints
    int64_t padded_joints
    int64_t center  # index of the root, -1 for the centroid
    int64_t flat  # whether the similarity takes the pose as one array
    int64_t moving_joints  # joints that can move relative to the centre
    int64_t filtered_joints  # padded joints, or 0 without a One-Euro filter
    int64_t average_size
    int64_t ring
    int64_t slot  # length of a summary, float64 numbers
    int64_t slot_count
    int64_t memo_size
    int64_t history_size
    int64_t bouts
    int64_t notes
    int64_t samples  # bytes of the repetitions' samples
    int64_t capacity  # W
    int64_t room  # undecided key frames whose segments there are slots for, at most W
    int64_t most_events  # that one frame, or the end of a take, can cause
    # Settings; the row's own, so that a level can move while others stay.
    double window  # s
    int64_t smoothing
    double one_euro_cutoff
    double one_euro_beta
    double theta  # sigThre, share of the range
    double rest_seconds  # s
    int64_t rests  # whether they are segments of their own
    int64_t range_policy
    double range_min
    double range_max
    double range_half_life
    double range_floor  # m, for all joints together
    double noise_margin  # 0 if it is off
    double spacing  # s, minimum interval of processed frames
    double max_gap  # s
    double max_speed  # m/s
    double max_pause  # s
    double hold  # s, after which a key frame is decided
    int64_t alpha  # α of Algorithm 3: this many key frames are kept whatever their strength; 0 for none
    double beta  # β of Algorithm 3, the level, as a strength
    int64_t location
    double refine  # s
    double pre_roll  # s
    double post_roll  # s
    int64_t tempo  # whether costs are divided by the tempo
    int64_t own_time  # whether evidence follows the performer's own time, see scales.pxi
    int64_t is_filtered  # see `Traits` in similarity/summary.py
    int64_t is_rms
    int64_t has_features
    int64_t is_mean
    int64_t repetitions  # whether they are counted here
    int64_t ends_alone  # whether its takes end when no joint is seen; a limb's end with the body's
    uint64_t details  # a bit for each of the first 64 joints that is not reported as active
    int64_t adopts  # whether the periods of the body are copied here
    int64_t labels_late  # whether labels wait for counted repetitions
    int64_t offline  # keep every key frame until the take ends, and decide then


cdef void derive_sizes(Plan* plan) noexcept nogil:
    """Set the sizes that follow from others."""
    cdef int64_t costs = (8 if plan.has_features == 1 else 4) * (plan.capacity + 1)  # with features they change more often
    plan.padded_joints = (plan.joints + PADDING - 1) // PADDING * PADDING
    plan.slot_count = plan.room + SPARE_SLOTS
    plan.memo_size = 1
    while plan.memo_size < costs:
        plan.memo_size *= 2
    plan.samples = samples_size(plan.joints) if plan.repetitions == 1 else 0
    plan.most_events = 8 * plan.capacity + 32
