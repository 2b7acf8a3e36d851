"""Envelope and splitter: Algorithms 1 and 2 of the paper, one value at a time.

`Ceiling` and `Floor` follow the curve at a distance of θ (Algorithm 1). A local minimum found at Floor becomes
the candidate, a lower one replaces it, and the next local maximum found at Ceiling accepts it; crossings of the
threshold line are key frames at once (Algorithm 2).

Three things the paper leaves open. V = θ counts as resting. A candidate is forgotten at every crossing (the
text's "end of the process"; Table 1, last row). A plateau is one extremum, at its first frame.

One thing is ours: early confirmation. When the curve has come back up to the Ceiling after a candidate, a local
maximum at Ceiling must follow before anything else can happen to the candidate, so it is accepted at the first
frame with V[t] >= Ceiling[t-1]. The list is the same, except that at the end of a take one key frame may have been
confirmed whose maximum never came: it is withdrawn then.
"""

from mossar_stream.jit.decorators import inline_kernel, kernel

CROSSED, CONFIRMED, PROMOTED, REPLACED, WITHDRAWN = 1, 2, 4, 8, 16


@kernel
def start_curve(h, value, scale):
    """Begin a curve: no crossing and no extremum at its first frame."""
    theta = h.theta * scale
    h.ceiling = theta
    h.floor = theta
    h.candidate = -1
    h.awaiting = 0
    h.moving = 1 if value > theta else 0
    _update_envelope(h, value, theta)
    _begin_run(h, value, scale)
    h.falling = 0
    h.testable = 0


@inline_kernel
def follow_curve(h, value, scale, frame, time):
    """Take the next value in; what happened is returned as flags.

    Args:
        h: Header of the row; `run_*` describe the run of equal values that ended with the last frame.
        value: V[t], on the scale of `scale`.
        scale: What 1 is on that scale.
        frame: Number of this frame.
        time: s.

    Returns:
        A sum of PROMOTED (the run's first frame is now the candidate), REPLACED (and there was one before),
        CONFIRMED (the candidate is a key frame), CROSSED (this frame is a key frame), WITHDRAWN (and the
        candidate is not).
    """
    theta = h.theta * scale
    happened = _test_run(h, value)
    if value < h.value:
        h.awaiting = 0
    ceiling = h.ceiling
    _update_envelope(h, value, theta)
    moving = 1 if value > theta else 0
    if moving != h.moving:
        happened |= CROSSED if h.candidate < 0 else CROSSED | WITHDRAWN
        h.moving = moving
        h.awaiting = 0
        _next_run(h, value, scale, frame, time, 0)
        h.testable = 0
        return happened
    if h.candidate >= 0 and value >= ceiling:
        happened |= CONFIRMED
        h.awaiting = 1
    _next_run(h, value, scale, frame, time, moving)
    return happened


@kernel
def _update_envelope(h, value, theta):
    """Algorithm 1."""
    if value > h.ceiling:
        h.ceiling = value
        h.floor = max(value - theta, theta)
    elif value < h.floor:
        h.floor = max(value, theta)
        h.ceiling = min(value + theta, h.ceiling)


@kernel
def _test_run(h, value):
    """Algorithm 2, lines 12 to 15: make the run that ends a candidate if it is a significant minimum."""
    if h.testable == 0 or h.falling == 0 or not value > h.value:
        return 0
    if h.candidate >= 0 and not h.value < h.candidate_value:
        return 0
    happened = PROMOTED if h.candidate < 0 else PROMOTED | REPLACED
    h.candidate = h.run_frame
    h.candidate_time = h.run_time
    h.candidate_value = h.value
    h.candidate_share = h.share
    return happened


@kernel
def _next_run(h, value, scale, frame, time, moving):
    """Start a new run of equal values unless this one goes on."""
    if value == h.value:
        h.run_length += 1
        return
    h.falling = 1 if value < h.value else 0
    h.testable = 1 if moving == 1 and value == h.floor else 0
    h.run_frame = frame
    h.run_time = time
    _begin_run(h, value, scale)


@kernel
def _begin_run(h, value, scale):
    h.value = value
    h.run_length = 1
    h.share = value / scale if scale > 0.0 else 0.0
