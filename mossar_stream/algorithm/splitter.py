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
And whether a run was a minimum shows at the first value after it, so lines 12 to 14 come one value late.

One thing is ours: early confirmation. When the curve has come back up to the Ceiling after a candidate, a local
maximum at Ceiling must follow before anything else can happen to the candidate, so it is accepted at the first
frame with V[t] >= Ceiling[t-1]. The list is the same, except that at the end of a take one key frame may have been
confirmed whose maximum never came: it is withdrawn then. `tools/checks/reference/algorithms.py` has the paper's form.
"""

import numpy as np

from mossar_stream.jit.decorators import inline_kernel, kernel

CROSSED, ACCEPTED, PROMOTED, REPLACED, FORGOTTEN = 1, 2, 4, 8, 16  # what can be found in a frame

FOUND_IN_FRAME = np.dtype(  # in the last frame
    [
        ("happened", "i8"),  # flags; 0 when dealt with
        ("former_frame", "i8"),  # the candidate that was replaced
        ("former_time", "f8"),
        ("former_share", "f8"),
        ("frame", "i8"),  # the candidate that was promoted, forgotten or confirmed
        ("time", "f8"),
        ("share", "f8"),
    ],
)
CURVE = np.dtype(
    [
        ("ceiling", "f8"),  # Ceiling[t], on the scale of V
        ("floor", "f8"),  # Floor[t]
        ("moving", "i8"),  # whether V[t] > sigThre
        ("value", "f8"),  # V[t]
        ("share", "f8"),  # the same as a share of the range
        # The run of equal values that V[t] belongs to.
        ("run_frame", "i8"),  # first frame
        ("run_time", "f8"),  # s
        ("run_length", "i8"),
        ("falling", "i8"),  # whether it was entered from above
        ("at_floor", "i8"),  # whether its first frame is at Floor, moving, and no crossing
        # c, the candidate.
        ("candidate", "i8"),  # frame, -1 for None
        ("candidate_time", "f8"),  # s
        ("candidate_value", "f8"),  # V[c]
        ("candidate_share", "f8"),
        ("awaiting", "i8"),  # whether the maximum that accepts the newest minimum is still to come
        ("found", FOUND_IN_FRAME),
    ],
)


@kernel
def start_curve(curve, value, sig_threshold, scale, frame, time):
    """Algorithm 2, lines 2 to 5, and line 8 for the first frame, which is no crossing and no extremum."""
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
    found = curve.found
    found.happened = found.former_frame = found.frame = 0
    found.former_time = found.former_share = found.time = found.share = 0.0


@kernel
def update_envelope(curve, value, sig_threshold):
    """Algorithm 1."""
    if value > curve.ceiling:
        curve.ceiling = value
        curve.floor = max(value - sig_threshold, sig_threshold)
    elif value < curve.floor:
        curve.floor = max(value, sig_threshold)
        curve.ceiling = min(value + sig_threshold, curve.ceiling)


@inline_kernel
def follow_curve(curve, value, sig_threshold, scale, frame, time):
    """Algorithm 2, lines 8 to 19, for the next frame.

    Args:
        curve: CURVE; what happened is noted in `curve.found`.
        value: V[t], on the scale of `scale`.
        sig_threshold: θ on that scale.
        scale: What 1 is on that scale.
        frame: t, number of the frame.
        time: s.

    Returns:
        A sum of PROMOTED (the run before this frame is now the candidate), REPLACED (and there was one before),
        CONFIRMED (the candidate is a key frame), CROSSED (this frame is a key frame), WITHDRAWN (and the
        candidate is not). A candidate that is confirmed or withdrawn is left to be forgotten by `forget_candidate`.
    """
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
    found = curve.found
    found.happened = happened
    if happened != 0:
        found.frame, found.time, found.share = curve.candidate, curve.candidate_time, curve.candidate_share
    return happened


@inline_kernel
def forget_candidate(curve):
    """Algorithm 2, line 19, and the end of the process at a crossing."""
    curve.candidate = -1


@kernel
def _test_minimum(curve, value):
    """Algorithm 2, lines 12 to 14: let the run that ends be the candidate if it is a significant minimum."""
    if curve.at_floor == 0 or curve.falling == 0 or not value > curve.value:
        return 0
    if curve.candidate >= 0 and not curve.value < curve.candidate_value:
        return 0
    happened = PROMOTED
    if curve.candidate >= 0:
        happened = PROMOTED | REPLACED
        found = curve.found
        found.former_frame = curve.candidate
        found.former_time = curve.candidate_time
        found.former_share = curve.candidate_share
    curve.candidate = curve.run_frame
    curve.candidate_time = curve.run_time
    curve.candidate_value = curve.value
    curve.candidate_share = curve.share
    return happened


@kernel
def _follow_run(curve, value, scale, frame, time):
    """Start a new run of equal values unless the last one goes on."""
    if value == curve.value:
        curve.run_length += 1
        return
    curve.falling = 1 if value < curve.value else 0
    curve.at_floor = 1 if curve.moving == 1 and value == curve.floor else 0
    _start_run(curve, value, scale, frame, time)


@kernel
def _start_run(curve, value, scale, frame, time):
    curve.value = value
    curve.share = value / scale if scale > 0.0 else 0.0
    curve.run_frame = frame
    curve.run_time = time
    curve.run_length = 1
