"""Summaries: what is kept of a segment instead of its frames.

A summary is a slot: a vector of float64 numbers that begins with the fields below; what follows belongs to the
similarity measure in use. Summaries are mergeable: the summary of two neighbouring segments together follows
from theirs, so that no frame need be kept (`algorithm.md` 2; Chan, Golub and LeVeque 1979).
"""

FRAMES = 0  # number of frames
MOVING = 1  # of them in a moving period
DURATION = 2  # s, the sum of their time steps
TERM = 3  # what the similarity keeps about the closed segment as a whole
PATH = 4  # (lanes,) m, path of each joint relative to the centre; then the similarity's own part

SHORTEST = 1e-6  # s; a segment that lasts no longer says nothing
