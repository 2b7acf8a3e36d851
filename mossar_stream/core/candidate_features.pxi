"""Candidate features: the evidence on a candidate, from the frame that it is found at until its key frame is confirmed.

Features of single frames are noted in `note_speed`, those of the candidate's frame in `note_place`; `features_of` puts them
together, in the units of the performer's own scales.
"""

cdef double SMOOTHING = 0.05  # s, time constant of the poses' low-pass filter
cdef double EARLIER = 0.06  # s, delay of velocity and low-pass filter
cdef double EARLIER_IN_NOISE = 0.12  # s, the same while noise is loud, when the velocity is that of the filtered poses
cdef double SPEED_SETTLING = 0.1  # s at the start of a take, in which the filter settles and noise is not known
# Refractory period, s, between key frames that are reported when Algorithm 2 accepts them; the shorter one if the later one
# is slow
cdef double INTERVAL = 0.36
cdef double SHORT_INTERVAL = 0.25
cdef double RISEN = 1.2  # times the speed at the key frame that the speed must have reached before
cdef double QUICK = 3.0  # V; a faster performer is in the midst of a move
cdef double REPORTED_ABOVE_NOISE = 2.5  # times the sensor's noise that a speed must have reached before
cdef enum:
    NOT_PLACED = -1

cdef struct Candidate:
    # Reported frame: `EARLIER` than Algorithm 2's frame; NOT_PLACED if nothing was seen there.
    int64_t frame
    double time  # s
    double speed  # m/s, lowest since the candidate
    double rest_distance  # m, distance from the pose in which the performer dwells
    double peak  # m/s, largest since the last reported key frame
    int64_t before  # reported frame of the key frame before
    double reported_time  # s, of the last reported key frame
    double reported_speed  # m/s, lowest speed at that one


cdef void start_candidate(Candidate* candidate, int64_t frame, double time) noexcept nogil:
    """Begin a take."""
    candidate.frame = frame
    candidate.time = time
    candidate.speed = 0.0
    candidate.rest_distance = 0.0
    candidate.peak = 0.0
    candidate.before = frame
    candidate.reported_time = time + SPEED_SETTLING
    candidate.reported_speed = 0.0


cdef inline (float, float) smoothing_weights(double dt) noexcept nogil:
    """Return the weights of the last filtered pose and of the newest displacement.

    The filter is a first-order low-pass, exact for straight lines between the poses: it is late by SMOOTHING at any rate.
    """
    cdef double kept
    if dt <= 0.0:
        return (<float>1.0, <float>0.0)
    kept = exp(-dt / SMOOTHING)
    return (<float>kept, <float>(kept - (1.0 - kept) * SMOOTHING / dt))


cdef void note_place(
    Candidate* candidate, Scales* scales, PoseHistory* history, Floats body, double time, int64_t joints
) noexcept nogil:
    """Note the features of a candidate, or of a crossing, at the last frame.

    Args:
        candidate: CANDIDATE.
        scales: SCALES.
        history: PoseHistory.
        body: See joint_pages.pxi; the features are those of the last frame.
        time: s, reported time of the key frame.
        joints: Number of joints that can move relative to the centre.
    """
    cdef int64_t place
    candidate.speed = scales.speed
    candidate.rest_distance = rest_distance(body, joints)
    place = mark_at(history, time)
    if place >= 0:
        candidate.frame = history.marks.at[place].frame
        candidate.time = history.marks.at[place].time


cdef inline void note_speed(Candidate* candidate, Scales* scales, double time) noexcept nogil:
    """Note the speed of a frame, unless a key frame was reported just now."""
    if time > candidate.reported_time + MARGIN:
        candidate.peak = max(candidate.peak, scales.speed)


cdef inline double noise_of_speed(Noise* noise, int64_t joints) noexcept nogil:
    """Return the speed that the sensor's noise adds to the filtered poses, m/s.

    White noise takes each joint √6 σ a frame; filtered with weight a, and over the speed window, it takes it
    √(6 a / (2 - a)) σ.
    """
    cdef double share
    if noise.step <= 0.0:
        return 0.0
    share = noise.step / (noise.step + SMOOTHING)
    return noise_level(noise) / joints * noise.step * sqrt(share / (2.0 - share)) / SPEED_WINDOW


cdef Features features_of(Candidate* candidate, Scales* scales, bint own_time, double noise, int64_t joints) noexcept nogil:
    """Return `Features` of a key frame that is confirmed; `noise` in m/s, `joints` is the number that can move."""
    cdef double size = extent(scales), tempo = tempo_of(scales, own_time)
    return Features(candidate.speed, candidate.rest_distance / size, size, usual_speed(scales), tempo, noise, joints)


cdef inline bint is_reported(Candidate* candidate, Scales* scales, double time, double noise) noexcept nogil:
    """Return whether a key frame is reported at once: slow, apart from the last one, and not the sensor's noise.

    Within the refractory period a slower minimum is still reported: the first may have been a brief pause.
    """
    cdef bint slow, rose
    cdef double interval
    slow = candidate.speed <= QUICK * usual_speed(scales)
    rose = candidate.peak >= max(REPORTED_ABOVE_NOISE * noise, RISEN * candidate.speed)
    interval = SHORT_INTERVAL if candidate.speed <= RISEN * candidate.reported_speed else INTERVAL
    return slow and rose and time - candidate.reported_time >= interval - MARGIN
