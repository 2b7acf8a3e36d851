"""Summaries (`summary.pxi`) in Python: their requirements on frames and key frames."""

from typing import NamedTuple


class Traits(NamedTuple):
    """The requirements of a measure on frames and key frames.

    Args:
        is_filtered: Poses are low-pass filtered, and log speeds are relative to the usual speed.
        is_rms: The velocity is that of the joints' rms path, instead of the sum of their paths.
        has_features: Key frames come with `Features`, which need filtered poses: they are reported after a refractory
            period, at the frame that the poses show, and judged by counted repetitions.
        is_mean: Costs are means over all joints, those that do not count included.
    """

    is_filtered: bool = False
    is_rms: bool = False
    has_features: bool = False
    is_mean: bool = False
