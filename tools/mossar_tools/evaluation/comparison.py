"""Comparison: how unlike the two segments on both sides of a frame are, at frames all over a take.

This is the part of Li and Leung's method that costs time, in compiled code, on the core's path kernel.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.decorators import entry_point
from mossar_stream.memory.joint_pages import pad
from mossar_stream.recording import segment_recording
from mossar_stream.settings import Settings
from mossar_stream.similarity.protocol import add_pose, close, make_params, merge_into, slot_size, strength
from mossar_tools.evaluation.takes import Take

Floats = NDArray[np.float64]


class Comparison:
    """Compares the segment that ends with the one that begins at frames of a take.

    Args:
        take: The take.
        settings: Of the path kernel.
        piece: Length of the pieces that segments are made of, s: the search precision.
        size: Length of the later segment, pieces.

    Attributes:
        pieces: How many there are; piece i begins at `starts[i]`.
        starts: (pieces,) s.
    """

    def __init__(self, take: Take, settings: Settings, piece: float, size: int) -> None:
        resolved = settings.replace(level=take.level, location="none").resolved()
        curves = segment_recording(
            take.positions, take.fps, take.skeleton, resolved, times=take.times, curves=True
        ).curves
        joints, lanes = len(take.skeleton), pad(len(take.skeleton))
        poses = np.zeros((len(curves), 4, lanes), np.float32)
        for frame, state in enumerate(curves):
            poses[frame, :3, :joints] = state.pose.T
        times = np.array([state.time for state in curves])
        self._params = make_params(resolved, joints, lanes, take.skeleton.root)
        self.pieces = max(1, int((times[-1] - times[0]) / piece))
        self.starts = times[0] + piece * np.arange(self.pieces)
        self._size = size
        self._slots = np.zeros((self.pieces, slot_size(resolved, self._params)))
        self._later = np.zeros_like(self._slots)
        fill(self._params, poses, times, np.searchsorted(times, self.starts), self._slots, joints)
        gather(self._params, self._slots, size, self._later)

    def between(self, first: int, last: int, longest: int) -> Floats:
        """Return how unlike the segments beside the start of each piece are.

        Args:
            first: Piece where the earlier segments begin.
            last: Piece before which the later segments end.
            longest: Of the earlier segments, pieces.

        Returns:
            (last - first + 1,) strengths; those where a segment would be shorter than `size` are -1.
        """
        found = np.full(last - first + 1, -1.0)
        compare(self._params, self._slots, self._later, first, self._size, longest, found)
        return found


@entry_point
def fill(params, poses, times, starts, slots, joints):
    """Summarise the pieces.

    Args:
        params: (1,) record of the measure.
        poses: (n, 4, lanes) m relative to the centre.
        times: (n,) s.
        starts: (pieces,) first frame of each.
        slots: (pieces, slot) summaries, zero; set.
        joints: J.
    """
    for i in range(len(slots)):
        end = starts[i + 1] if i + 1 < len(slots) else len(times)
        for frame in range(starts[i], end):
            weight = times[frame] - times[frame - 1] if frame > 0 else 0.0
            add_pose(params[0], slots[i], poses[frame], joints, times[frame], weight)


@entry_point
def gather(params, slots, size, later):
    """Set `later` to the summaries of `size` pieces from each piece on, closed."""
    for i in range(len(slots) - size + 1):
        for k in range(i, i + size):
            merge_into(params[0], later[i], slots[k])
        close(params[0], later[i])


@entry_point
def compare(params, slots, later, first, size, longest, found):
    """Set the strengths at pieces from `first` on; see `Comparison.between`."""
    earlier, closed, both = np.zeros(slots.shape[1]), np.zeros(slots.shape[1]), np.zeros(slots.shape[1])
    for i in range(len(found)):
        if i > longest:
            earlier[:] = 0.0
            for k in range(first + i - longest, first + i - 1):
                merge_into(params[0], earlier, slots[k])
        if i > 0:
            merge_into(params[0], earlier, slots[first + i - 1])
        if size <= i <= len(found) - 1 - size:
            closed[:] = earlier
            close(params[0], closed)
            found[i] = strength(params[0], closed, later[first + i], both)
