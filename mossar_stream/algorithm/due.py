"""Due: when the oldest undecided key frame must be decided, and candidates are judged."""

import numpy as np

from mossar_stream.algorithm.verdicts import FREE, JUDGED_AFTER, due_verdict, judge
from mossar_stream.jit.decorators import inline_kernel, kernel


@inline_kernel
def set_due_time(w):
    """Set when the oldest undecided key frame must be decided, or a verdict on a candidate is due."""
    due = np.inf
    if w.state.undecided > 0 and w.plan.offline == 0:
        due = w.keys[0].time + w.plan.hold
    if w.plan.evidence == 1:
        due = min(due, due_verdict(w.verdicts, verdict_delay(w.plan)))
    w.state.due_time = due


@inline_kernel
def verdict_delay(plan):
    """Return how old a candidate is when it is judged, s: decided it is not earlier."""
    return min(plan.hold, JUDGED_AFTER)


@kernel
def judge_candidates(w, until):
    """Judge the candidates that are due until some time, s, and let their key frames know."""
    first = w.state.ordinal - w.state.undecided
    while due_verdict(w.verdicts, verdict_delay(w.plan)) <= until:
        ordinal = w.verdicts.state.judged
        verdict = judge(w.verdicts)
        if ordinal >= first and verdict != FREE:
            w.keys[ordinal - first].verdict = verdict
            w.state.ranked = 0


@inline_kernel
def is_due(w):
    """Tell whether the oldest key frame must be decided now."""
    state = w.state
    if state.undecided == 0:
        return False
    return state.undecided > w.plan.capacity or w.clock.time >= w.keys[0].time + w.plan.hold
