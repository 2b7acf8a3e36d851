"""Layout: how the bytes of followed examples, and of a performer who is followed, are laid out.

Only this file knows the places of the parts of a store and of a performer's memory; Python asks.
"""

cdef double PERIOD = 1.0 / 15.0  # s between two samples of a stream, and between two phases of an example
cdef enum:
    MOST_PHASES = 150  # 10 s; of longer examples a phase lasts several samples
    LANES = 8  # phases that are computed at once
    LAYERS = 2  # of cells: ways that have come on with the latest sample, and those that have stayed
    LONGER = 16  # samples beyond twice an example that are remembered
    RECENT_SAMPLES = 16  # samples of which the progress is remembered, for the tempo
    TEMPO_SAMPLES = 15  # over which it is taken: 1 s
    LATEST_DONE = 16  # performances whose time is remembered
    RING_LENGTHS = 5  # times an example, of samples that are remembered: a counted repetition is known a whole one later

cdef struct FollowHead:  # The head of a bank; its arrays follow.
    int64_t points  # K
    int64_t bones  # B
    int64_t examples  # T
    int64_t moves  # M
    int64_t limbs  # that have bones
    int64_t girdles[4]  # points of the hips, then of the shoulders, left first; -1 if they are not known
    int64_t axis  # that points upwards
    double sign
    int64_t strides  # R, how many different ones the examples have
    int64_t ring  # samples that are remembered of each
    int64_t longest  # phases of the longest example
    int64_t phases  # the same, padded


cdef struct Bone:
    int64_t begin  # point
    int64_t end  # point
    int64_t limb  # -1 for none


cdef struct FollowedExample:
    int64_t move
    int64_t phases
    int64_t padded  # phases, padded
    int64_t stride  # samples that a phase lasts
    int64_t ring  # which of the rings has its samples
    double still  # mean square of the chord between its bones and their mean directions
    double dear  # the same, no chord counted beyond `CAP`; costs are relative to it
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
    double residual  # cost without constant differences
    double best  # rank of the best end that is not decided yet, inf if there is none
    double best_gain
    int64_t best_first  # sample
    int64_t best_last
    int64_t best_layer
    int64_t best_example
    double done  # rank of the latest performance that was done, inf if there is none
    int64_t done_first  # its samples
    int64_t done_last
    int64_t repeated  # whether the counter's current repetitions are this move
    double settled  # s, until when counted repetitions were looked at
    double lasts  # s, the latest of them that was the move
    int64_t surplus  # performances that were done beyond them
    double middles[16]  # LATEST_DONE, s, of the latest performances that were done, on the way there
    int64_t refused  # why the latest end of the performance was not done
    float recent[16]  # RECENT_SAMPLES, progress at the last samples
    int64_t recents


cdef struct FollowReport:  # The numbers reported of a move, rounded; the deviation of each limb follows.
    double number
    double rev
    double count
    double start
    double time
    double progress
    double tempo
    double deviation  # degrees
    double posture  # degrees, its part that is the same from begin to end
    double joint  # bone that strays farthest, -1 for none
    double example
    double cost
    double gain
    double went
    double residual
    double refused


cdef struct FollowingState:
    double due  # -inf: samples lie between two frames, so every frame is needed; see core/reader.pxi
    int64_t frames  # since the last gap
    int64_t samples  # since the last gap
    double time  # s, of the last frame
    double begin  # s, of the first sample since the last gap; the others follow every `PERIOD`
    double sampled  # s, of the last sample
    double facing[2]  # x and z, slowly following
    double every  # s, setting `follow_every`
    int64_t number  # of the latest performance of the take
    int64_t happened  # whether anything did


cdef struct FollowBank:  # The parts of a bank: followed moves, described for a stream.
    FollowHead* head
    JointPair* points  # (K,) the centre first
    Bone* bones  # (B,)
    FollowedExample* examples  # (T,)
    float* floats  # the first pose, then of each example directions and their means, then weights of bones


cdef struct FollowMemory:  # The parts of a performer's memory, besides the cells of examples.
    uint8_t* memory
    FollowingState* state
    Periods* periods  # counted repetitions of the body, as of the last analysis
    FollowedMove* moves  # (M,)
    FollowedMove* spare  # (1,) scratch
    int64_t* happened  # (M,) at the last frame
    DoubleRows reports  # (M, numbers of a `FollowReport` and limbs)
    FloatPlanes poses  # (2, K, 3) m, of the last two frames
    float* absences  # (K,) s, for which each point has been missing
    FloatRows directions  # (B, 3) of the sample
    float* distances  # (n,) scratch: of the sample from each phase
    float* products  # (n,) scratch: the same, how far it lies in the phase's direction
    FloatRows strays  # (M, B) mean square of chords; `UNJUDGED` of hidden bones
    FloatRows standing  # (M, B) square of the mean chord
    float* boxes  # (M, 2, B, 3) least and largest directions of the last performance
    float* rings  # (R, ring, B, 3) directions of the last samples
    FloatRows means  # (B, 3) scratch: mean difference of directions along a way
    Int32Rows way  # (2, 2 * ring) scratch: samples and phases that a way brings together
    BytePlanes hidden  # (R, ring, B) whether each bone was hidden in the last samples
    uint8_t* scratch  # cells of the longest example, in which a counted repetition is aligned
    uint8_t* end  # where the cells of the first example begin


# State of the ways of aligning the stream with one example: one way ends in each phase, and layer.
cdef struct Cells:
    Int32Rows firsts  # (LAYERS, n) sample where the way began
    FloatRows costs  # (LAYERS, n) summed over phases; inf where there is no way
    FloatRows weights  # (LAYERS, n) of the summed costs
    FloatRows gains  # (LAYERS, n) summed over phases
    ByteRows steps  # (ring, n) how ways have come on, at each sample
    uint8_t* end


cdef inline FollowBank open_follow_bank(uint8_t* store) noexcept nogil:
    """Return the parts of a bank."""
    return lay_out_follow_bank(store, <FollowHead*>store)


cdef FollowBank lay_out_follow_bank(uint8_t* store, FollowHead* head) noexcept nogil:
    """Return where the parts of a bank with this head lie; nothing of it is read."""
    cdef FollowBank bank
    bank.head = head
    bank.points = <JointPair*>(store + sizeof(FollowHead))
    bank.bones = <Bone*>(bank.points + head.points)
    bank.examples = <FollowedExample*>(bank.bones + head.bones)
    bank.floats = <float*>(bank.examples + head.examples)
    return bank


cdef inline FloatRows first_pose(FollowBank* bank) noexcept nogil:
    """Return the points at the begin of the first example, relative to the centre, (K, 3) m."""
    return floats_in_rows(bank.floats, bank.head.points, 3)


cdef inline FloatPlanes directions_of_followed(FollowBank* bank, FollowedExample* example) noexcept nogil:
    """Return the directions of an example, (B, 3, padded phases)."""
    cdef FloatPlanes found
    found.at = bank.floats + example.rows
    found.planes, found.rows, found.columns = bank.head.bones, 3, example.padded
    return found


cdef inline FloatRows means_of_followed(FollowBank* bank, FollowedExample* example) noexcept nogil:
    """Return the mean directions of an example, (B, 3)."""
    return floats_in_rows(
        bank.floats + example.rows + 3 * bank.head.bones * example.padded, bank.head.bones, 3
    )


cdef inline FloatRows weights_of_bones(FollowBank* bank) noexcept nogil:
    """Return how much each bone counts in the deviation from an example, (T, B); each row adds up to 1."""
    cdef FollowHead* head
    cdef FollowedExample* last
    cdef int64_t begin
    head = bank.head
    begin = 3 * head.points
    if head.examples > 0:
        last = &bank.examples[head.examples - 1]
        begin = last.rows + floats_of_followed(last.phases, head.bones)
    return floats_in_rows(bank.floats + begin, head.examples, head.bones)


cdef FollowMemory open_follow_memory(uint8_t* memory, FollowHead* head) noexcept nogil:
    """Return the parts of a performer's memory; nothing of it is read."""
    cdef FollowMemory known
    cdef int64_t points, bones, moves, taken
    points, bones, moves = head.points, head.bones, head.moves
    known.memory = memory
    known.state = <FollowingState*>memory
    known.periods = <Periods*>(memory + sizeof(FollowingState))
    known.moves = <FollowedMove*>(known.periods + 1)
    known.spare = known.moves + moves
    known.happened = <int64_t*>(known.spare + 1)
    known.reports = doubles_in_rows(
        <double*>(known.happened + moves), moves, sizeof(FollowReport) // sizeof(double) + head.limbs
    )
    known.poses.at = <float*>(known.reports.at + moves * known.reports.columns)
    known.poses.planes, known.poses.rows, known.poses.columns = 2, points, 3
    known.absences = known.poses.at + 6 * points
    known.directions = floats_in_rows(known.absences + points, bones, 3)
    known.distances = known.directions.at + 3 * bones
    known.products = known.distances + head.phases
    known.strays = floats_in_rows(known.products + head.phases, moves, bones)
    known.standing = floats_in_rows(known.strays.at + moves * bones, moves, bones)
    known.boxes = known.standing.at + moves * bones
    known.rings = known.boxes + moves * 6 * bones
    known.means = floats_in_rows(known.rings + head.strides * head.ring * 3 * bones, bones, 3)
    known.way = ints32_in_rows(<int32_t*>(known.means.at + 3 * bones), 2, 2 * head.ring)
    known.hidden.at = <uint8_t*>(known.way.at + 4 * head.ring)
    known.hidden.planes, known.hidden.rows, known.hidden.columns = head.strides, head.ring, bones
    taken = known.hidden.at - memory
    known.scratch = memory + in_words(taken) + in_words(head.strides * head.ring * bones)
    known.end = lay_out_cells(known.scratch, head.longest).end
    return known


cdef inline FloatPlanes ring_of(FollowMemory* known, int64_t ring) noexcept nogil:
    """Return the directions of the last samples in a ring, (ring, B, 3)."""
    cdef FloatPlanes found
    found.planes, found.rows, found.columns = known.hidden.rows, known.hidden.columns, 3
    found.at = known.rings + ring * found.planes * found.rows * 3
    return found


cdef inline float* row_of_ring(FollowMemory* known, int64_t ring, int64_t line) noexcept nogil:
    """Return the directions of one of the last samples, (B, 3)."""
    return known.rings + (ring * known.hidden.rows + line) * known.hidden.columns * 3


cdef inline FloatPlanes box_of(FollowMemory* known, int64_t m) noexcept nogil:
    """Return the least and the largest directions of the last performance of a move, (2, B, 3)."""
    cdef FloatPlanes found
    found.planes, found.rows, found.columns = 2, known.strays.columns, 3
    found.at = known.boxes + m * 6 * found.rows
    return found


cdef inline Cells open_cells(uint8_t* memory, FollowedExample* example) noexcept nogil:
    """Return the cells of an example in the memory of a performer; nothing of it is read."""
    return lay_out_cells(memory + example.memory, example.phases)


cdef Cells lay_out_cells(uint8_t* begin, int64_t phases) noexcept nogil:
    """Return where the cells of so many phases lie; nothing of them is read."""
    cdef Cells cells
    cells.firsts = ints32_in_rows(<int32_t*>begin, LAYERS, phases)
    cells.costs = floats_in_rows(<float*>(cells.firsts.at + LAYERS * phases), LAYERS, phases)
    cells.weights = floats_in_rows(cells.costs.at + LAYERS * phases, LAYERS, phases)
    cells.gains = floats_in_rows(cells.weights.at + LAYERS * phases, LAYERS, phases)
    cells.steps = bytes_in_rows(<uint8_t*>(cells.gains.at + LAYERS * phases), ring_size(phases), phases)
    cells.end = cells.steps.at + in_words(cells.steps.rows * phases)
    return cells


cdef inline int64_t ring_size(int64_t phases) noexcept nogil:
    """Return how many samples must be remembered to follow so many phases at half their tempo."""
    return 2 * phases + LONGER


cdef inline int64_t in_lanes(int64_t phases) noexcept nogil:
    """Return how many numbers so many phases take, which are computed `LANES` at once."""
    return (phases + LANES - 1) // LANES * LANES


cdef inline int64_t floats_of_followed(int64_t phases, int64_t bones) noexcept nogil:
    """Return how many numbers the directions of an example and their means take."""
    return 3 * bones * (in_lanes(phases) + 1)


cdef inline int64_t in_words(int64_t size) noexcept nogil:
    """Return the bytes that whole words of eight take, which hold so many."""
    return (size + 7) // 8 * 8


cdef inline int64_t in_ring(int64_t number, int64_t size) noexcept nogil:
    """Return the line of a ring where a sample lies; its number may be negative."""
    cdef int64_t line
    line = number % size
    return line + size if line < 0 else line


cdef void place_examples(FollowBank* bank) noexcept nogil:
    """Note where directions and cells of examples lie, and `ring` and `phases` of the head."""
    cdef FollowHead* head
    cdef FollowedExample* example
    cdef uint8_t* cells
    cdef int64_t t, at, longest
    head = bank.head
    longest = 0
    for t in range(head.examples):
        longest = max(longest, bank.examples[t].phases)
    head.longest = longest
    head.ring = RING_LENGTHS * longest + LONGER
    head.phases = in_lanes(longest)
    at = 3 * head.points
    cells = open_follow_memory(NOWHERE, head).end
    for t in range(head.examples):
        example = &bank.examples[t]
        example.padded = in_lanes(example.phases)
        example.rows = at
        example.memory = cells - NOWHERE
        at += floats_of_followed(example.phases, head.bones)
        cells = open_cells(NOWHERE, example).end


cdef void begin_follow_memory(uint8_t* memory, FollowBank* bank) noexcept nogil:
    """Set the memory of a performer to its state before the first frame of a take, but for `every`."""
    cdef FollowMemory known
    cdef Cells cells
    cdef int64_t m, t
    memset(memory, 0, follow_memory_size(bank))
    known = open_follow_memory(memory, bank.head)
    known.state.due = -INFINITY
    for m in range(bank.head.moves):
        known.moves[m].best = known.moves[m].done = INFINITY
        forget_repetitions(&known.moves[m])
    for t in range(bank.head.examples):
        cells = open_cells(memory, &bank.examples[t])
        for m in range(LAYERS * cells.costs.columns):
            cells.costs.at[m] = INFINITY


cdef inline void forget_repetitions(FollowedMove* move) noexcept nogil:
    """Forget the counted repetitions, and when the move was done."""
    cdef int64_t i
    move.repeated = move.surplus = 0
    move.settled = -INFINITY
    for i in range(LATEST_DONE):
        move.middles[i] = -INFINITY


cdef int64_t follow_memory_size(FollowBank* bank) noexcept nogil:
    """Return the bytes that following takes for one performer."""
    if bank.head.examples > 0:
        return open_cells(NOWHERE, &bank.examples[bank.head.examples - 1]).end - NOWHERE
    return open_follow_memory(NOWHERE, bank.head).end - NOWHERE
