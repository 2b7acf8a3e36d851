"""Similarity: the small protocol that lets one remerge work with any measure, and the measures there are.

A measure is a module with

    add_frame(params, summary, frame)             one frame into a summary, or into sums in the body that wait
    flush_sums(params, summary, body, padded_joints)
                                                  the sums that wait into the summary
    add_pose(params, summary, pose, joints, time, weight)
                                                  its pose alone, in or out (weight < 0)
    add_joint(params, summary, pose, joints, j)   a joint that was missing so far, as if it had rest where it is all along
    merge_into(params, target, other)             two neighbours into one summary
    close(params, summary)                        what is kept about a whole segment
    strength(params, left, right, both)           at which the key frame between them falls, >= 0
    merge_cost(params, left, right, both)         the same where `both` is the summary of both already
    similarity(params, cost, left, right)         in 0..1, for people to read; cost is strength, and the summaries
                                                  need not be closed
    write_features(params, summary, features)     `Features` of the key frame that ends a segment, if it asks for them

all kernels, on summaries as described in `summary.py`; in plain Python `slot_size(params)`, `takes_pose(params)`,
whether `add_frame` looks at the pose as one array, and `are_sound(params, slots)`, which looks through summaries that
come from outside; `traits()`, what frames and key frames must be like; and a numpy record type for its parameters. The
type of the record selects the module when a kernel is compiled, so that one measure does not compile the others. A new
measure is one such module and one row in `MEASURES`.
"""


# NOT COMPILED IN ANY RUN: protocol_add_frame
# def add_frame(params, summary, frame):
#     """Add one frame, a `SummaryFrame`, to a summary."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_add_pose
# def add_pose(params, summary, pose, joints, time, weight):
#     """Add a frame's pose to a summary, or take it out."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_add_joint
# def add_joint(params, summary, pose, joints, j):
#     """Add a joint that was missing so far to a summary."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_flush_sums
# def flush_sums(params, summary, body, padded_joints):
#     """Add the sums that wait to a summary."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_merge_into
# def merge_into(params, target, other):
#     """Make a summary that of two neighbouring segments."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_close
# def close(params, summary):
#     """Finish a summary."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_strength
# def strength(params, left, right, both):
#     """Return the strength of the key frame between two segments."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_merge_cost
# def merge_cost(params, left, right, both):
#     """Return the strength of the key frame between two segments whose common summary is known."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_similarity
# def similarity(params, cost, left, right):
#     """Return the similarity of two segments, given the strength of the key frame between them."""
#     raise NotImplementedError


# NOT COMPILED IN ANY RUN: protocol_write_features
# def write_features(params, summary, features):
#     """Write what is known of a key frame into the summary of the segment that it ends."""
#     raise NotImplementedError
