"""State of one performer's repetitions: a record of fixed size, and samples.

A sample is a pose that has moved far enough from the sample before (sampling.pxi). Samples lie coordinate by coordinate, as
16-bit multiples of a quantum, so that both products of a power iteration run along contiguous memory. The root may go far:
its own path is kept in floats.
"""

cdef double MOST_RATE = 30.0  # Hz, of the processed frames, at most
cdef enum:
    SAMPLES = 120  # kept
    LEAST_SAMPLES = 8  # in a window that is analysed
    RECENT = 40  # samples: if they swing much less than the window, another posture came first
    STRIDE = 10  # samples after which the window is analysed,
cdef double ANALYSIS_INTERVAL = 1.0  # s, at the latest, if there is a new sample
cdef enum:
    COMPONENTS = 4  # leading ones of the posture; cycles are compared in them
    REST_POSE_FRAMES = 15  # first frames of a take; their mean is the rest pose
    CYCLES = 32  # remembered; more than fit into the window
    CHAINS = 24  # at most: pairs of bones, such as upper arm and forearm, that show the pose of limbs
cdef float MOST_QUANTA = 32767.0  # largest multiple of the quantum
cdef double SMALLEST_QUANTUM = 1.0 / 8192.0  # m: reaches 4 m from the root
cdef double LEAST_REACH = 8.0  # times the rms distance of joints from their centre, least reach of all quanta
cdef enum:
    POSTURES = 9  # that describe a cycle
    BINS = 64  # of histograms

cdef struct Cycle:
    int64_t start  # sample at which the cycle begins, counted from the start of the take
    int64_t far  # sample of the other extreme
    int64_t end
    double leaves  # s since the take began, like all times: it leaves the pose in which it begins,
    double out  # passes half way to the other extreme,
    double turns  # is in the middle of its stay there,
    double back  # passes half way back,
    double arrives  # and arrives
    int64_t returning  # 1 if it may still be on its way back
    double amplitude  # m, rms over joints, from one extreme to the other
    int64_t count  # in its bout, from 1
    int64_t joint  # that moves most
    double straighter  # straightness of limbs at the start minus that at the other extreme
    double resting  # how much more the movement dwells at the start and is near the rest pose, from -1 to 1
    double lead  # share of a cycle before the first one of its bout
    int64_t turned  # 1 if repetitions begin at the other extreme
    double begins  # s, where the repetition begins, and
    double ends  # where it ends, see timing.pxi
    double period  # s, NaN of the first in a bout


cdef struct Counting:
    int64_t joints
    int64_t root
    int64_t travels  # 1 if the root's own path is part of the posture
    double least  # m, rms over joints: smaller swings are not counted
    int64_t chains  # number of them
    int64_t chain[24][3]  # joints: the end of one bone, the shared joint, the end of the other
    int64_t begun  # 1 after the first frame of a take
    double origin  # s, time of that frame
    double latest  # s, time of the latest frame
    double wanted  # s, earliest time of the next frame to process
    int64_t unseen  # coordinates that no frame of the take had
    int64_t frames  # processed
    double middle  # s, time of the frame before, which is the middle one of three
    double noise  # m², of the sensor: variance of a pose, summed over all coordinates
    double size  # m², sum of the squared distances of joints from their centre at the start of the take
    float quantum  # m, unit of the samples
    float per_quantum  # 1/m
    double step  # m², least squared difference of a pose from the last sample, summed over all coordinates
    double wander  # m², farthest squared distance of the pose from the last sample, and
    int64_t returns  # the number of times it came back: small movements, which a large step misses
    int64_t fine  # first sample since the step was last made smaller
    int64_t open  # samples of the take
    int64_t first  # sample that may belong to the window: before it there was a long rest
    int64_t analysed  # samples at the last analysis
    double due  # s, when the next analysis is due
    double at[120]  # s since the take began, times of the samples, ring buffer
    double left[120]  # s, end of the stay in the pose of the sample
    int64_t clear  # 1 once some cycles agreed beyond doubt; nothing is reported before
    int64_t dropped  # cycles that are no longer remembered
    int64_t cycles  # remembered ones
    int64_t changed  # the first remembered cycle that the last analysis changed
    Cycle cycle[32]


cdef struct CountedCycle:
    double begins
    double ends
    double period
    int64_t count


cdef struct Periods:  # for evidence: the body's repetitions, in its row and in those of its limbs
    double origin  # this and the others as in `Counting`
    int64_t analysed
    int64_t clear
    int64_t cycles
    CountedCycle cycle[32]


cdef struct Winner:
    double covered
    int64_t count
    int64_t component
    int64_t width
    int64_t clear


cdef struct CountingScratch:
    int32_t turns[2][120]  # see `turning_points`
    int32_t cycles[3][120]  # start, far extreme, end
    int32_t kept[3][120]  # those that are alike
    int32_t best[3][120]  # those of the proposal that wins so far
    int32_t missed[3]  # one
    float shapes[60][9][4]  # descriptions of cycles
    float totals[60][5]  # sums of each component of them, and of all squares
    double alike[60]  # agreement of each cycle with the next
    int32_t counts[64]  # of a histogram
    double least  # swing of scores; smaller swings are not counted
    Winner winner


cdef struct Samples:  # of one performer; D = 3 · joints
    ShortRows ring  # (D, SAMPLES) samples in quanta, joints relative to the root; each line a ring buffer
    FloatRows root  # (3, SAMPLES) m, the root of each sample: its own path, or 0; ring buffers as `ring`
    FloatRows axes  # (COMPONENTS, D), unit vectors
    Floats straight  # (SAMPLES,) straightness of limbs, 0 to 2, ring buffer as `ring`
    Floats last  # (D,) m, pose of the last sample
    Floats older  # (D,) m, pose of the frame before `before`
    Floats before  # (D,) m, pose of the frame before
    Floats rest_pose  # (D,) m, mean pose of the take's first `REST_POSE_FRAMES` frames
    Floats pose  # (D,) latest known, NaN before a joint was seen
    # Workspace of an analysis; performers share it, because they are analysed one after the other.
    FloatRows by_coordinate  # (D, SAMPLES), m, in the order of time
    FloatRows scores  # (COMPONENTS, SAMPLES), in the order of time
    FloatRows smooth  # (COMPONENTS, SAMPLES), means of neighbouring scores
    Floats rest_pose_scores  # (COMPONENTS,) of the pose `rest_pose`, as `scores`


cdef inline int64_t in_lines(int64_t size) noexcept nogil:
    """Return a number of bytes, rounded up to whole lines of the cache."""
    return (size + CACHE_LINE - 1) // CACHE_LINE * CACHE_LINE


cdef inline int64_t periods_at() noexcept nogil:
    """Return the offset of `Periods` in the bytes of a performer's count: they follow `Counting`."""
    return in_lines(sizeof(Counting))


cdef inline int64_t samples_at() noexcept nogil:
    """Return the offset of the samples in those bytes: they follow `Periods`."""
    return periods_at() + in_lines(sizeof(Periods))


cdef int64_t samples_size(int64_t joints) noexcept nogil:
    """Return the size of a performer's `Samples` without the workspace, bytes."""
    return 3 * joints * (2 * SAMPLES + 4 * (COMPONENTS + 5)) + 4 * 4 * SAMPLES


cdef int64_t store_size(int64_t joints) noexcept nogil:
    """Return the size of the workspace of an analysis for a number of joints, bytes: `CountingScratch`, then numbers."""
    return in_lines(sizeof(CountingScratch)) + 4 * (3 * joints * SAMPLES + COMPONENTS * (2 * SAMPLES + 1))


cdef inline Samples stored_samples(uint8_t* memory, int64_t joints) noexcept nogil:
    """Return views of a performer's samples, without the workspace of an analysis."""
    cdef int64_t d = 3 * joints
    cdef int64_t n = SAMPLES if joints > 0 else 0
    cdef float* root = <float*>(memory + 2 * d * SAMPLES)
    cdef float* axes = root + 3 * n
    cdef float* straight = axes + COMPONENTS * d
    cdef float* poses = straight + n
    cdef Samples samples
    samples.ring = shorts_in_rows(<int16_t*>memory, d, SAMPLES)
    samples.root = floats_in_rows(root, 3, n)
    samples.axes = floats_in_rows(axes, COMPONENTS, d)
    samples.straight = floats(straight, n)
    samples.last = floats(poses, d)
    samples.older = floats(poses + d, d)
    samples.before = floats(poses + 2 * d, d)
    samples.rest_pose = floats(poses + 3 * d, d)
    samples.pose = floats(poses + 4 * d, d)
    return samples


cdef inline Samples all_samples(uint8_t* memory, float* room, int64_t joints) noexcept nogil:
    """Return views of a performer's samples and of the workspace of an analysis."""
    cdef int64_t d = 3 * joints
    cdef Samples samples = stored_samples(memory, joints)
    samples.by_coordinate = floats_in_rows(room, d, SAMPLES)
    samples.scores = floats_in_rows(room + d * SAMPLES, COMPONENTS, SAMPLES)
    samples.smooth = floats_in_rows(room + (d + COMPONENTS) * SAMPLES, COMPONENTS, SAMPLES)
    samples.rest_pose_scores = floats(room + (d + 2 * COMPONENTS) * SAMPLES, COMPONENTS)
    return samples


cdef inline Int32Rows in_cycles(int32_t* first, int64_t rows) noexcept nogil:
    """Return rows of the scratch that hold numbers of samples."""
    return ints32_in_rows(first, rows, SAMPLES)


cdef inline void fill_floats(Floats span, float value) noexcept nogil:
    """Set all numbers to a value."""
    cdef int64_t i
    for i in range(span.count):
        span.at[i] = value


cdef void begin(Counting* header, Samples* samples, double time) noexcept nogil:
    """Begin a take: forget everything but the skeleton.

    Args:
        header: `Counting`.
        samples: `Samples`.
        time: s, of the first frame.
    """
    header.begun = 1
    header.origin = header.latest = header.wanted = time
    header.unseen = 3 * header.joints
    header.frames = header.open = header.clear = header.dropped = header.cycles = header.changed = 0
    header.first = header.fine = header.returns = 0
    header.noise = header.size = header.step = header.wander = header.middle = 0.0
    note_analysis(header)
    header.quantum, header.per_quantum = SMALLEST_QUANTUM, 1.0 / SMALLEST_QUANTUM
    fill_floats(floats(samples.axes.at, samples.axes.rows * samples.axes.columns), 0.0)
    fill_floats(samples.rest_pose, 0.0)
    fill_floats(samples.pose, NAN)


cdef void forget_periods(Periods* periods) noexcept nogil:
    """Clear the periods at the start of a take."""
    periods.clear = periods.cycles = periods.analysed = 0


cdef void copy_periods(Periods* periods, Periods* counted) noexcept nogil:
    """Copy the periods of the body's repetitions to those of a limb or a reader."""
    cdef int64_t q
    periods.origin, periods.analysed = counted.origin, counted.analysed
    periods.clear, periods.cycles = counted.clear, counted.cycles
    for q in range(counted.cycles):
        periods.cycle[q] = counted.cycle[q]


cdef inline void renew_periods(Periods* periods, Periods* counted) noexcept nogil:
    """Copy them if they were analysed since."""
    if periods.analysed != counted.analysed or periods.origin != counted.origin:
        copy_periods(periods, counted)


cdef void note_periods(Periods* periods, Counting* counted) noexcept nogil:
    """Copy the counted cycles to the periods, which evidence reads."""
    cdef int64_t q
    cdef CountedCycle* to
    cdef Cycle* cycle
    periods.origin, periods.analysed = counted.origin, counted.analysed
    periods.clear, periods.cycles = counted.clear, counted.cycles
    for q in range(counted.cycles):
        to = &periods.cycle[q]
        cycle = &counted.cycle[q]
        to.begins, to.ends, to.period, to.count = cycle.begins, cycle.ends, cycle.period, cycle.count


cdef void note_analysis(Counting* header) noexcept nogil:
    """Note that all samples were analysed; the next sample sets the time of the next analysis."""
    header.analysed = header.open
    header.due = INFINITY


cdef inline int64_t window_size(Counting* header) noexcept nogil:
    """Return the number of samples in the window."""
    return min(header.open - header.first, SAMPLES)


cdef inline int64_t ring_place(Counting* header, int64_t n, int64_t i) noexcept nogil:
    """Return the place in the ring of the i-th of the n samples in the window."""
    return (header.open - n + i) % SAMPLES
