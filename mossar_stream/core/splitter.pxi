"""Splitter: Algorithms 1 and 2 of the paper, one value at a time.

    Algorithm 1   Derivation of Ceiling and Floor at time t

     1  procedure updateEnvelope()
     2    if V[t] > Ceiling[t-1] then
     3      Ceiling[t] = V[t]
     4      Floor[t] = max(V[t] - sigThre, sigThre)
     5    else if V[t] < Floor[t-1] then
     6      Floor[t] = max(V[t], sigThre)
     7      Ceiling[t] = min(V[t] + sigThre, Ceiling[t-1])
     8    else
     9      Floor[t] = Floor[t-1]
    10      Ceiling[t] = Ceiling[t-1]

    Algorithm 2   Generation of a list of key frames

     1  procedure generateListOfKeyFrames()
     2    List = ∅
     3    c = None
     4    Ceiling[0] = sigThre
     5    Floor[0] = sigThre
     7    for t = 0; t < F; t++ do
     8      updateEnvelope()
     9      if crossSigThreLine() then
    10        List.add(t)
    11      else if V[t] > sigThre then
    12        if isLocalMinimum(V[t]) and V[t] == Floor[t] then
    13          if c == None or V[t] < V[c] then
    14            c = t
    16        else if isLocalMaximum(V[t]) and V[t] == Ceiling[t] then
    17          if c != None then
    18            List.add(c)
    19            c = None

Three things the paper leaves open. V = θ counts as resting. A candidate is forgotten at every crossing (the
text's "end of the process"; Table 1, last row). A plateau is one extremum, at its first frame: a run of equal values.

Two things follow from the stream. sigThre is on the scale of V: θ · range, for a stream knows its range only so far.
The first value after a run shows whether it was a minimum, so lines 12 to 14 come one value late.

One thing is ours: early confirmation. When the curve has come back up to the Ceiling after a candidate, a local
maximum at Ceiling must follow before anything else can happen to the candidate, so it is accepted at the first
frame with V[t] >= Ceiling[t-1]. The list is the same, except that at the end of a take one key frame may have been
confirmed whose maximum never came: it is withdrawn then. `tools/checks/reference/algorithms.py` has the paper's form.
"""

cdef enum:
    CROSSED = 1  # flags of a frame
    ACCEPTED = 2
    PROMOTED = 4
    REPLACED = 8
    FORGOTTEN = 16

cdef struct FoundInFrame:  # in the last frame
    int64_t happened  # flags; 0 when dealt with
    int64_t former_frame  # the candidate that was replaced
    double former_time
    double former_share
    int64_t frame  # the candidate that was promoted, forgotten or confirmed
    double time
    double share


cdef struct Curve:
    double ceiling  # Ceiling[t], on the scale of V
    double floor  # Floor[t]
    int64_t moving  # whether V[t] > sigThre
    double value  # V[t]
    double share  # the same as a share of the range
    # The run of equal values that V[t] belongs to.
    int64_t run_frame  # first frame
    double run_time  # s
    int64_t run_length
    int64_t falling  # whether it was entered from above
    int64_t at_floor  # whether its first frame is at Floor, moving, and no crossing
    # c, the candidate.
    int64_t candidate  # frame, -1 for None
    double candidate_time  # s
    double candidate_value  # V[c]
    double candidate_share
    int64_t awaiting  # whether the maximum that accepts the newest minimum is still to come
    FoundInFrame found


cdef void start_curve(
    Curve* curve, double value, double sig_threshold, double scale, int64_t frame, double time
) noexcept nogil:
    """Algorithm 2, lines 2 to 5, and line 8 for the first frame, which is no crossing and no extremum."""
    cdef FoundInFrame* found
    curve.candidate = -1
    curve.candidate_time = curve.candidate_value = curve.candidate_share = 0.0
    curve.ceiling = sig_threshold
    curve.floor = sig_threshold
    update_envelope(curve, value, sig_threshold)
    curve.moving = 1 if value > sig_threshold else 0
    _start_run(curve, value, scale, frame, time)
    curve.falling = 0
    curve.at_floor = 0
    curve.awaiting = 0
    found = &curve.found
    found.happened = found.former_frame = found.frame = 0
    found.former_time = found.former_share = found.time = found.share = 0.0


cdef void update_envelope(Curve* curve, double value, double sig_threshold) noexcept nogil:
    """Algorithm 1."""
    if value > curve.ceiling:
        curve.ceiling = value
        curve.floor = max(value - sig_threshold, sig_threshold)
    elif value < curve.floor:
        curve.floor = max(value, sig_threshold)
        curve.ceiling = min(value + sig_threshold, curve.ceiling)


cdef inline int64_t follow_curve(
    Curve* curve, double value, double sig_threshold, double scale, int64_t frame, double time
) noexcept nogil:
    """Algorithm 2, lines 8 to 19, for the next frame.

    Args:
        curve: CURVE; `curve.found` is set.
        value: V[t], on the scale of `scale`.
        sig_threshold: θ on that scale.
        scale: Value of 1 on that scale.
        frame: t, number of the frame.
        time: s.

    Returns:
        A sum of PROMOTED (the run before this frame is now the candidate), REPLACED (and there was one before),
        CONFIRMED (the candidate is a key frame), CROSSED (this frame is a key frame), WITHDRAWN (and the
        candidate is not). The caller forgets a confirmed or withdrawn candidate with `forget_candidate`.
    """
    cdef double ceiling
    cdef int64_t happened, moving
    cdef bint crossed
    cdef FoundInFrame* found
    ceiling = curve.ceiling
    update_envelope(curve, value, sig_threshold)  # line 8
    happened = _test_minimum(curve, value)  # lines 12 to 14, for the run before this frame
    if value < curve.value:
        curve.awaiting = 0
    moving = 1 if value > sig_threshold else 0
    crossed = moving != curve.moving
    if crossed:  # lines 9 and 10
        happened |= CROSSED if curve.candidate < 0 else CROSSED | FORGOTTEN
        curve.moving = moving
        curve.awaiting = 0
    elif curve.candidate >= 0 and value >= ceiling:  # lines 16 to 18, early
        happened |= ACCEPTED
        curve.awaiting = 1
    _follow_run(curve, value, scale, frame, time)
    if crossed:
        curve.at_floor = 0
    found = &curve.found
    found.happened = happened
    if happened != 0:
        found.frame, found.time, found.share = curve.candidate, curve.candidate_time, curve.candidate_share
    return happened


cdef inline void forget_candidate(Curve* curve) noexcept nogil:
    """Algorithm 2, line 19, and the end of the process at a crossing."""
    curve.candidate = -1


cdef int64_t _test_minimum(Curve* curve, double value) noexcept nogil:
    """Algorithm 2, lines 12 to 14: make the run that ends the candidate if it is a significant minimum."""
    cdef int64_t happened
    cdef FoundInFrame* found
    if curve.at_floor == 0 or curve.falling == 0 or not value > curve.value:
        return 0
    if curve.candidate >= 0 and not curve.value < curve.candidate_value:
        return 0
    happened = PROMOTED
    if curve.candidate >= 0:
        happened = PROMOTED | REPLACED
        found = &curve.found
        found.former_frame = curve.candidate
        found.former_time = curve.candidate_time
        found.former_share = curve.candidate_share
    curve.candidate = curve.run_frame
    curve.candidate_time = curve.run_time
    curve.candidate_value = curve.value
    curve.candidate_share = curve.share
    return happened


cdef void _follow_run(Curve* curve, double value, double scale, int64_t frame, double time) noexcept nogil:
    """Start a new run of equal values unless the last one goes on."""
    if value == curve.value:
        curve.run_length += 1
        return
    curve.falling = 1 if value < curve.value else 0
    curve.at_floor = 1 if curve.moving == 1 and value == curve.floor else 0
    _start_run(curve, value, scale, frame, time)


cdef void _start_run(Curve* curve, double value, double scale, int64_t frame, double time) noexcept nogil:
    curve.value = value
    curve.share = value / scale if scale > 0.0 else 0.0
    curve.run_frame = frame
    curve.run_time = time
    curve.run_length = 1
