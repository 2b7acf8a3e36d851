"""Similarity: the small protocol that lets one remerge work with any measure, and the measures there are.

A measure is a kind, a record of parameters, and functions on summaries as described in `summary.pxi`. A Python module
fills the record and states the requirements of the measure (`protocol.py`). A new measure is a file beside
this one, such a module and a row in `MEASURES`, a kind, a member of `Measure`, and a branch in each function below.
"""

cdef enum:  # Kinds of measures, in the order of `MEASURES`.
    EVIDENCE = 0
    LIKELIHOOD = 1
    PATH_KERNEL = 2


cdef struct Measure:  # The measure in use; of the records only that of its kind is set.
    int64_t kind
    Evidence evidence
    Likelihood likelihood
    PathKernel path_kernel


cdef void add_frame(Measure* measure, Doubles summary, SummaryFrame* frame) noexcept nogil:
    """Add one frame to a summary, or to sums in the body that wait."""
    if measure.kind == EVIDENCE:
        evidence_add_frame(&measure.evidence, summary, frame)
    elif measure.kind == LIKELIHOOD:
        likelihood_add_frame(&measure.likelihood, summary, frame)
    else:
        path_kernel_add_frame(&measure.path_kernel, summary, frame)


cdef void flush_sums(Measure* measure, Doubles summary, Floats body, int64_t padded_joints) noexcept nogil:
    """Add the sums that wait to a summary."""
    if measure.kind == EVIDENCE:
        flush_waiting(&measure.evidence.sums, summary, body, padded_joints)
    elif measure.kind == LIKELIHOOD:
        flush_waiting(&measure.likelihood.sums, summary, body, padded_joints)


cdef void add_pose(
    Measure* measure, Doubles summary, FloatRows pose, int64_t joints, double time, double weight
) noexcept nogil:
    """Add a frame's pose to a summary, or take it out (weight < 0); not to frames, paths and the peak."""
    if measure.kind == EVIDENCE:
        add_pose_sums(&measure.evidence.sums, summary, pose, weight)
    elif measure.kind == LIKELIHOOD:
        likelihood_add_pose(&measure.likelihood, summary, pose, joints, weight)
    else:
        path_kernel_add_pose(&measure.path_kernel, summary, pose, time, weight)


cdef void add_joint(
    Measure* measure, Doubles summary, FloatRows pose, int64_t joints, int64_t j
) noexcept nogil:
    """Add a joint that was missing so far to a summary, as if it had rested at its present place all the time."""
    if measure.kind == EVIDENCE:
        add_resting_joint(&measure.evidence.sums, summary, pose, j)
    elif measure.kind == LIKELIHOOD:
        likelihood_add_joint(&measure.likelihood, summary, pose, joints, j)
    else:
        path_kernel_add_joint(&measure.path_kernel, summary, pose, j)


cdef void merge_into(Measure* measure, Doubles target, Doubles other) noexcept nogil:
    """Make a summary that of two neighbouring segments."""
    if measure.kind == EVIDENCE:
        evidence_merge_into(&measure.evidence, target, other)
    elif measure.kind == LIKELIHOOD:
        add_all(target.at, other.at, target.count)
    else:
        path_kernel_merge_into(&measure.path_kernel, target, other)


cdef void close(Measure* measure, Doubles summary) noexcept nogil:
    """Complete the summary of a whole segment; evidence adds nothing, since its comparison depends on the key frame."""
    if measure.kind == EVIDENCE:
        summary.at[TERM] = 0.0
    elif measure.kind == LIKELIHOOD:
        likelihood_close(&measure.likelihood, summary)
    else:
        path_kernel_close(&measure.path_kernel, summary)


cdef double strength(Measure* measure, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two closed segments, >= 0; `both` is scratch."""
    if measure.kind == EVIDENCE:
        return evidence_strength(&measure.evidence, left, right, both)
    if measure.kind == LIKELIHOOD:
        return likelihood_strength(&measure.likelihood, left, right, both)
    return path_kernel_strength(&measure.path_kernel, left, right)


cdef double merge_cost(Measure* measure, Doubles left, Doubles right, Doubles both) noexcept nogil:
    """Return the strength of the key frame between two closed segments whose common summary is known."""
    if measure.kind == EVIDENCE:
        return evidence_merge_cost(&measure.evidence, left, right, both)
    if measure.kind == LIKELIHOOD:
        return likelihood_merge_cost(&measure.likelihood, left, right, both)
    return path_kernel_strength(&measure.path_kernel, left, right)


cdef double similarity(Measure* measure, double cost, Doubles left, Doubles right) noexcept nogil:
    """Return the similarity of two segments in 0..1, for people to read.

    Args:
        measure: The measure.
        cost: Strength of the key frame between them.
        left: Summary of the earlier one, which need not be closed.
        right: Of the later one.
    """
    if measure.kind == PATH_KERNEL:
        return path_kernel_similarity(&measure.path_kernel, cost, left, right)
    return 1.0 / (1.0 + cost)


cdef void write_features(Measure* measure, Doubles summary, Features features) noexcept nogil:
    """Write the features of a key frame into the summary of the segment that it ends, if the measure needs them."""
    if measure.kind == EVIDENCE:
        evidence_write_features(&measure.evidence, summary, &features)
