"""Noise: the sensor's part of the velocity, so that a person who stands still causes no flood of key frames.

A sensor that errs by a millimetre moves all joints all the time: at 120 Hz that is as much path as a slow walk.
No limit on the velocity separates the two, but the direction does: motion goes on, noise turns back. The
displacement of a joint that only trembles has the correlation -1/2 with the one before, that of a moving joint
one near 1. While most displacements turn back, the path is the sensor's, and the velocity that it adds is known from
then on. Where that is too much for the threshold line,

    displacements are smoothed (first-order low-pass, time constant at most `SLOWEST_SMOOTHING`), and
    the range does not fall below where θ · range is `noise_margin` times the noise that is left.

Where poses are low-pass filtered (level `motion`), small movements must not be silenced: there the velocity is that of
the filtered poses while noise is loud, and the range rises to at most `MOST_RAISED` times its value. A joint that
jumps turns back, too, while others move; there the noise is at most the quietest path of late (the minimum statistics
of Martin 2001).

The first moment of a stream counts as noise, too, so that it need not begin with a false onset. Recordings with little
noise, and performers who never rest, are otherwise unchanged. This is ours; preset `paper` and the `fixed` range switch
it off.
"""

cdef double MEMORY = 0.15  # s, time constant of the averages
cdef double TURNED_BACK = -0.1  # correlation of successive displacements below which they are noise
cdef double BEGINNING = 0.05  # s, at the start of a stream, in which every movement may be noise
# s, without any displacement, after which the sensor is exactly still; shorter ones are repeated frames
cdef double STILLNESS = 0.1
cdef double DOUBT = 0.5  # added to the estimate for each frame's share in it
cdef double SLOWEST_SMOOTHING = 0.1  # s, time constant of the smoothing
cdef double DOUBLING = 5.0  # s, in which the quietest path that is remembered doubles
# Where poses are filtered, θ · range is raised so many standard deviations above the velocity that the noise adds, but not
# beyond so many times its value without noise.
cdef double DEVIATIONS = 4.0
cdef double MOST_RAISED = 3.0
cdef double UNEVEN = 1.6  # a step in time so many times the usual one has lost frames; in it, motion may turn back
cdef double ALWAYS_EVEN = 0.03  # s, steps that are even in any case (frames may come in bursts), and in no case
cdef double NEVER_EVEN = 0.1
cdef double SHORTER_STEP = 0.8  # makes about one step in six shorter than the usual one
cdef double LONGER_STEP = 1.04

cdef struct RecentSums:  # leaky sums over the last frames of a take
    double time  # s, since the last frame that was not a repetition
    double span  # s, that the following sums stand for
    double path  # m
    double turn  # s, correlation of successive displacements
    double squares  # m², of the last displacements
    double still  # s, for which exactly nothing moved before the last displacement


cdef struct Noise:  # estimate of the sensor's noise; it outlasts a take
    int64_t known  # whether it was ever calm
    int64_t silent  # whether the sensor was ever exactly still: until it is calm, it has no noise
    double heard  # s, of movement
    double estimate  # m/s, path of the noise of all joints
    double aside  # m/s, the estimate where the setting noise_margin is 0: only the activity knows of it
    double quietest  # m/s, path of all joints when it was quietest of late; 0 if that is not known
    int64_t loud  # whether the velocity is that of filtered poses
    double floor  # m, the range does not fall below it
    double step  # s, usual time between frames
    int64_t smooth  # whether the last displacement was smoothed
    RecentSums recent


cdef void start_noise(RecentSums* recent) noexcept nogil:
    """Begin a take: nothing was heard of late."""
    recent.time = 0.0
    recent.span = 0.0
    recent.path = 0.0
    recent.turn = 0.0
    recent.squares = 0.0
    recent.still = 0.0


cdef inline double calm_noise(
    Noise* noise, Plan* plan, double largest, Floats body, double displacement, double dt
) noexcept nogil:
    """Process a frame, set `noise.floor`, and return the frame's path with the noise smoothed out.

    Where poses are filtered it sets `noise.loud` instead, and returns the path unchanged.

    Args:
        noise: NOISE.
        plan: PLAN.
        largest: m, velocity so far.
        body: Displacements of the joints, now, before, and smoothed; 0 where one is missing or back after a gap.
        displacement: m, path of all; repeated frames have none and are ignored.
        dt: s since the last frame, 0 for the first.

    Returns:
        Path of all joints, m.
    """
    cdef double level, loudness, line, share
    hear_noise(noise, body, plan.padded_joints, displacement, dt)
    level = noise_level(noise) if plan.is_filtered == 1 else noise.estimate
    loudness = level * plan.window * plan.noise_margin
    line = plan.theta * max(largest, plan.range_floor)
    noise.floor = 0.0
    noise.loud = 1 if plan.is_filtered == 1 and dt > 0.0 and loudness > line else 0
    if dt <= 0.0 or plan.is_filtered == 1 or not loudness > line:  # it does not come too near to the line
        noise.smooth = 0
        return displacement
    share = _share(loudness, line, dt)
    noise.floor = loudness * share / sqrt(2.0 - share) / plan.theta
    return _smooth(noise, body, displacement, share)


cdef inline void hear_noise(
    Noise* noise, Floats body, int64_t padded_joints, double displacement, double dt
) noexcept nogil:
    """Update the estimate of the sensor's noise with a frame; see `calm_noise`."""
    cdef RecentSums* recent
    cdef double turned
    recent = &noise.recent
    recent.time += dt
    if displacement > 0.0 or dt <= 0.0:
        turned = _turned(recent, body, padded_joints)
        if _noise_is_even(noise, recent.time):
            _listen(noise, turned, displacement)
        else:
            recent.squares = 0.0  # nothing can be compared with this displacement
        recent.still = recent.time - dt
        noise.silent |= 1 if recent.still >= STILLNESS - TIME_ROUNDING else 0
        recent.time = 0.0


cdef inline bint ends_stillness(Noise* noise) noexcept nogil:
    """Return whether the last frame is the first with a displacement after exact stillness."""
    return noise.recent.time == 0.0 and noise.recent.still >= STILLNESS - TIME_ROUNDING


cdef inline void hear_aside(
    Noise* noise, Floats body, int64_t padded_joints, double displacement, double dt
) noexcept nogil:
    """Update the estimate that only the activity uses with a frame."""
    noise.estimate = noise.aside
    hear_noise(noise, body, padded_joints, displacement, dt)
    noise.aside, noise.estimate = noise.estimate, 0.0


cdef inline double noise_level(Noise* noise) noexcept nogil:
    """Return the path of the noise of all joints where poses are filtered, m/s."""
    return min(noise.estimate, noise.quietest) if noise.quietest > 0.0 else noise.estimate


cdef inline double noise_floor(double left, Plan* plan, double largest) noexcept nogil:
    """Return the lower limit of the range while noise is loud and poses are filtered, m.

    The rms of 3 J normal numbers has a standard deviation of 1/√(6 J) of itself.

    Args:
        left: m, the velocity that the noise adds to the filtered poses.
        plan: PLAN.
        largest: m, velocity so far.
    """
    cdef double least
    least = left * (1.0 + DEVIATIONS / sqrt(6.0 * plan.moving_joints))
    return min(least / plan.theta, MOST_RAISED * max(largest, plan.range_floor))


cdef inline double _turned(RecentSums* recent, Floats body, int64_t padded_joints) noexcept nogil:
    """Return the correlation of the displacements with the last ones, and keep them."""
    cdef double product, squares, scale
    cdef int64_t first
    cdef Floats page
    product = squares = 0.0
    for first from 0 <= first < padded_joints by PAGE:
        page = page_of(body, first)
        _turn(page)
        product += page_sum(page.at, WORK)
        squares += page_product(page.at, STEP, STEP)
    scale = sqrt(squares * recent.squares)
    recent.squares = squares
    return product / scale if scale > 0.0 else 0.0


cdef inline bint _noise_is_even(Noise* noise, double step) noexcept nogil:
    """Return whether the frame follows the last one without a loss, and learn the usual step."""
    cdef bint even
    if step <= 0.0 or noise.step == 0.0 and step > NEVER_EVEN + TIME_ROUNDING:
        return False
    if noise.step == 0.0 or step < noise.step - TIME_ROUNDING:
        noise.step = max(step, SHORTER_STEP * noise.step)
    even = step <= min(NEVER_EVEN, max(ALWAYS_EVEN, UNEVEN * noise.step)) + TIME_ROUNDING
    noise.step = max(noise.step, min(step, LONGER_STEP * noise.step))
    return even


cdef inline void _turn(Floats page) noexcept nogil:
    cdef int64_t j
    cdef float x, y, z
    for j in range(PAGE):
        x, y, z = page.at[j + MOVED_X], page.at[j + MOVED_Y], page.at[j + MOVED_Z]
        page.at[j + WORK] = x * page.at[j + LAST_X] + y * page.at[j + LAST_Y] + z * page.at[j + LAST_Z]
        page.at[j + LAST_X], page.at[j + LAST_Y], page.at[j + LAST_Z] = x, y, z


cdef inline void _listen(Noise* noise, double turned, double displacement) noexcept nogil:
    """Count the path of a frame as noise if joints keep turning back."""
    cdef RecentSums* recent
    cdef double time, keep, path, least
    cdef bint is_noise
    recent = &noise.recent
    time = recent.time
    keep = MEMORY / (MEMORY + time)
    recent.span = keep * (recent.span + time)
    recent.path = keep * (recent.path + displacement)
    recent.turn = keep * (recent.turn + turned * time)
    noise.heard += time
    if recent.span > BEGINNING + TIME_ROUNDING:
        path = recent.path / recent.span
        least = noise.quietest * exp2(time / DOUBLING)
        noise.quietest = min(least, path) if least > 0.0 else path
    is_noise = recent.turn < TURNED_BACK * recent.span
    if is_noise:
        noise.known = 1
    if is_noise or noise.known == 0 and noise.heard < BEGINNING - TIME_ROUNDING:
        # The average of few frames may be too low.
        noise.estimate = recent.path / recent.span * (1.0 + DOUBT * time / recent.span)
    elif noise.known == 0:
        noise.estimate = 0.0


cdef double _share(double loudness, double line, double dt) noexcept nogil:
    """Return the weight of the newest displacement that leaves as little noise as the line allows.

    A weight of a leaves a/√(2 - a) of the path of white noise.
    """
    cdef double k
    k = squared(line / loudness)
    return max(dt / (dt + SLOWEST_SMOOTHING), 0.5 * (sqrt(k * k + 8.0 * k) - k))


cdef double _smooth(Noise* noise, Floats body, double displacement, double share) noexcept nogil:
    """Smooth the displacements, and return their path."""
    cdef double keep, take, raw, smooth
    cdef int64_t first
    # Smoothing begins from rest, where noise becomes known.
    keep = 1.0 - share if noise.smooth == 1 else 0.0
    noise.smooth = 1
    take = share if displacement > 0.0 else 0.0
    for first from 0 <= first < body.count // LINES by PAGE:
        _smooth_page(page_of(body, first), <float>keep, <float>take)
    raw, smooth = line_sum(body, STEP), line_sum(body, WORK)
    return smooth * displacement / raw if raw > 0.0 else smooth


cdef void _smooth_page(Floats page, float keep, float take) noexcept nogil:
    cdef int64_t j
    cdef float x, y, z
    for j in range(PAGE):
        x = keep * page.at[j + SMOOTH_X] + take * page.at[j + LAST_X]
        y = keep * page.at[j + SMOOTH_Y] + take * page.at[j + LAST_Y]
        z = keep * page.at[j + SMOOTH_Z] + take * page.at[j + LAST_Z]
        page.at[j + SMOOTH_X], page.at[j + SMOOTH_Y], page.at[j + SMOOTH_Z] = x, y, z
        page.at[j + WORK] = sqrtf(x * x + y * y + z * z)
