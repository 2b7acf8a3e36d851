"""Plan: sizes and settings of one performer, which do not change while frames come in; `Plan.prepare` of plan.py sets them."""


cdef struct Plan:  # what does not change while frames come in; `Plan.prepare` sets it
    # Sizes.
    int64_t joints
    int64_t padded_joints
    int64_t center  # index of the root, -1 for the centroid
    int64_t flat  # whether the similarity takes the pose as one array
    int64_t moving_joints  # joints that can move relative to the centre
    int64_t filtered_joints  # padded joints, or 0 without a One-Euro filter
    int64_t average_size
    int64_t ring
    int64_t slot
    int64_t slot_count
    int64_t memo_size
    int64_t history_size
    int64_t bouts
    int64_t notes
    int64_t samples  # bytes of the repetitions' samples
    int64_t capacity  # W
    int64_t room  # with more undecided key frames than this the row must grow before the next frame
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
    int64_t ends_alone  # whether its takes end where nobody is seen; a limb's end with the body's
    uint64_t details  # a bit for each of the first 64 joints that is not reported as active
    int64_t adopts  # whether what is counted of the body is copied here
    int64_t labels_late  # whether labels wait for what is counted
    int64_t offline  # keep every key frame until the take ends, and decide then
