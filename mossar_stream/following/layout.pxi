"""Layout: how the bytes of followed examples, and of a performer who is followed, are laid out."""

cdef double PERIOD = 1.0 / 15.0  # s between two samples of a stream, and between two phases of an example
cdef enum:
    MOST_PHASES = 150  # 10 s; of longer examples a phase lasts several samples
    LANES = 8  # phases that are computed at once
    LAYERS = 2  # of cells: ways that have come on with the latest sample, and those that have stayed
    LONGER = 16  # samples beyond twice an example that are remembered
    RECENT_SAMPLES = 16  # samples of which the progress is remembered, for the tempo
    TEMPO_SAMPLES = 15  # over which it is taken: 1 s
    # What is reported of a move, as numbers; then the deviation of each limb.
# CHECK tuple REPORT = ('number', 'rev', 'count', 'start', 'time', 'progress', 'tempo', 'deviation', 'joint', 'example', 'cost', 'gain', 'went', 'residual')
cdef enum:
    BANK_HEAD_BYTES = BANK_HEAD.itemsize
    FOLLOWING_STATE_BYTES = 88
    MOVE_BYTES = 288
    FOLLOWED_BYTES = 80
    BONE_POINT_BYTES = 16
    BONE_BYTES = 24

cdef struct BankHead:
    int64_t points
    int64_t bones
    int64_t examples
    int64_t moves
    int64_t limbs  # that have bones
    int64_t left  # points of the hips, then of the shoulders; -1 if they are not known
    int64_t right
    int64_t left_shoulder
    int64_t right_shoulder
    int64_t axis  # that points upwards
    double sign
    int64_t strides  # how many different ones the examples have
    int64_t ring  # samples that are remembered of each
    int64_t phases  # of the longest example, padded


cdef struct BonePoint:
    int64_t one
    int64_t other


cdef struct Bone:
    int64_t begin  # points; limb -1 for none
    int64_t end  # points; limb -1 for none
    int64_t limb  # points; limb -1 for none


cdef struct FollowedExample:
    int64_t move
    int64_t phases
    int64_t padded  # phases, padded
    int64_t stride  # samples that a phase lasts
    int64_t ring  # which of the rings has its samples
    double still  # mean square of the chord between its bones and their mean directions
    double dear  # the same, no chord counted beyond `CAP`: what costs are relative to
    double farthest  # largest mean square of the chord between a phase and the first one
    int64_t rows  # where its directions begin, floats
    int64_t memory  # where its cells begin in the memory of a performer, bytes


cdef struct FollowedMove:
    int64_t active  # whether it is being made
    int64_t number  # of the latest performance
    int64_t count  # done in the take
    int64_t rev
    int64_t example  # of which the numbers are
    int64_t layer  # where the way is that they are of
    int64_t phase
    int64_t first  # its first and its last sample
    int64_t last
    double start  # s
    double time  # s, of the sample that the numbers are of
    double seen  # s, when it was last followed well
    double reported  # s, when an event was last due
    double progress
    double cost  # of the way, relative to a performer who stands still
    double gain  # how far the example's movement is found in the stream: 1 for all of it
    double went  # how far the performer has gone from the first pose, relative to the example
    double residual  # cost of what is left once constant differences are taken away
    double best  # rank of the best end that is not decided yet, inf if there is none
    double best_gain
    int64_t best_first  # sample
    int64_t best_last
    int64_t best_layer
    int64_t best_example
    double done  # rank of the latest performance that was done, inf if there is none
    int64_t done_first  # its samples
    int64_t done_last
    float recent[16]  # progress at the last samples
    int64_t recents


cdef struct FollowingState:
    double due  # -inf: samples lie between two frames, so every frame is needed; see readers.py
    int64_t frames  # since the last gap
    int64_t samples  # since the last gap
    double time  # s, of the last frame
    double next  # s, when the next sample is due
    double sampled  # s, of the last sample
    double facing[2]  # x and z, slowly following
    double every  # s, setting `follow_every`
    int64_t number  # of the latest performance of the take
    int64_t happened  # whether anything did



