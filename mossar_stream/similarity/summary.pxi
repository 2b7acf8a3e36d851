"""Summaries: vectors that stand for the frames of a segment.

A summary is a slot: a vector of float64 numbers that begins with the fields below; the rest belongs to the similarity
measure in use. Summaries are mergeable: the summary of two neighbouring segments together follows
from theirs, so that no frame need be kept (Chan, Golub and LeVeque 1979).
"""

cdef enum:
    FRAMES = 0  # number of frames
    MOVING_FRAMES = 1  # of them in a moving period
    DURATION = 2  # s, the sum of their time steps
    TERM = 3  # the similarity's number for the whole closed segment
    PATH = 4  # (padded joints,) m, path of each joint relative to the centre; then the similarity's own part

cdef double SHORTEST_SEGMENT = 1e-6  # s; a segment up to this is no evidence


cdef struct SummaryFrame:  # A frame to add to a summary.
    Floats body  # see joint_pages.pxi
    FloatRows pose  # (4, padded joints), m relative to the centre in 3 rows, log speed
    int64_t joints
    double time  # s
    double weight  # s that the frame stands for
    int64_t moving  # whether it is in a moving period
    double speed  # m/s, rms over the joints, see scales.pxi; 0 if the measure needs no features
