"""Summaries: what is kept of a segment instead of its frames.

A summary is a slot: a vector of float64 numbers that begins with the fields below; what follows belongs to the
similarity measure in use. Summaries are mergeable: the summary of two neighbouring segments together follows
from theirs, so that no frame need be kept (Chan, Golub and LeVeque 1979).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FRAMES = 0  # number of frames
MOVING_FRAMES = 1  # of them in a moving period
DURATION = 2  # s, the sum of their time steps
TERM = 3  # what the similarity keeps about the closed segment as a whole
PATH = 4  # (padded joints,) m, path of each joint relative to the centre; then the similarity's own part

SHORTEST_SEGMENT = 1e-6  # s; a segment that lasts no longer says nothing


class SummaryFrame(NamedTuple):
    """A frame as summaries take it in."""

    body: NDArray[np.float32]  # see joint_pages.py
    pose: NDArray[np.float32]  # (4, padded joints), m relative to the centre in 3 rows, log speed
    joints: int
    time: float  # s
    weight: float  # s that the frame stands for
    moving: int  # whether it is in a moving period
    speed: float  # m/s, rms over the joints, see scales.py; 0 where the measure does not ask for features


class Traits(NamedTuple):
    """What frames and key frames must be like for a measure.

    Args:
        is_filtered: Poses are low-pass filtered, and log speeds are relative to the usual speed.
        is_rms: The velocity is that of the joints' rms path, instead of the sum of their paths.
        has_features: Key frames come with `Features`, which need filtered poses: they are reported after a refractory
            period, where poses show them, and judged by what is repeated.
        is_mean: Costs are means over all joints, those that do not count included.
    """

    is_filtered: bool = False
    is_rms: bool = False
    has_features: bool = False
    is_mean: bool = False
