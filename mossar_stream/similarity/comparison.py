"""Comparison: how unlike the segments on both sides of a moment are, at moments all over a recording.

This is what Li and Leung's recursion asks of the path kernel, which this package compares Mossar with.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.decorators import entry_point
from mossar_stream.memory.joint_pages import pad
from mossar_stream.settings import Settings
from mossar_stream.similarity.protocol import add_pose, close, make_params, merge_into, slot_size, strength


class Comparison:
    """Compares the segment that ends with the one that begins at moments of a recording.

    Args:
        poses: (n, J, 3) m relative to the centre.
        times: (n,) s.
        settings: Of the similarity.
        root: Index of the body centre, -1 for the centroid.
        piece: Length of the pieces that segments are made of, s: the search precision.
        size: Length of the later segment, pieces.

    Attributes:
        pieces: How many there are; piece i begins at `starts[i]`.
        starts: (pieces,) s.
    """

    def __init__(
        self,
        poses: NDArray[np.float32],
        times: NDArray[np.float64],
        settings: Settings,
        root: int,
        piece: float,
        size: int,
    ) -> None:
        open_cache()
        resolved = settings.resolved()
        joints = poses.shape[1]
        lines = np.zeros((len(poses), 4, pad(joints)), np.float32)
        lines[:, :3, :joints] = poses.transpose(0, 2, 1)
        self._params = make_params(resolved, joints, pad(joints), root)
        self.pieces = max(1, int((times[-1] - times[0]) / piece))
        self.starts = times[0] + piece * np.arange(self.pieces)
        self._size = size
        self._summaries = np.zeros((self.pieces, slot_size(resolved, self._params)))
        self._later = np.zeros_like(self._summaries)
        _fill(self._params, lines, times, np.searchsorted(times, self.starts), self._summaries, joints)
        _gather(self._params, self._summaries, size, self._later)

    def between(self, first: int, last: int, longest: int) -> NDArray[np.float64]:
        """Return how unlike the segments beside the start of each piece are.

        Args:
            first: Piece where the earlier segments begin.
            last: Piece before which the later segments end.
            longest: Of the earlier segments, pieces.

        Returns:
            (last - first + 1,) strengths; those where a segment would be shorter than `size` are -1.
        """
        found = np.full(last - first + 1, -1.0)
        _compare(self._params, self._summaries, self._later, (first, self._size, longest), found)
        return found


@entry_point
def _fill(params, poses, times, starts, summaries, joints):
    """Summarise the pieces.

    Args:
        params: (1,) record of the measure.
        poses: (n, 4, padded_joints) m relative to the centre.
        times: (n,) s.
        starts: (pieces,) first frame of each.
        summaries: (pieces, slot), zero; set.
        joints: J.
    """
    for i in range(len(summaries)):
        end = starts[i + 1] if i + 1 < len(summaries) else len(times)
        for frame in range(starts[i], end):
            weight = times[frame] - times[frame - 1] if frame > 0 else 0.0
            add_pose(params[0], summaries[i], poses[frame], joints, times[frame], weight)


@entry_point
def _gather(params, summaries, size, later):
    """Set `later` to the summaries of `size` pieces from each piece on, closed."""
    for i in range(len(summaries) - size + 1):
        for k in range(i, i + size):
            merge_into(params[0], later[i], summaries[k])
        close(params[0], later[i])


@entry_point
def _compare(params, summaries, later, bounds, found):
    """Set the strengths at pieces from the first on; `bounds` are those of `Comparison.between` and the size."""
    first, size, longest = bounds
    slot = summaries.shape[1]
    earlier, closed, both = np.zeros(slot), np.zeros(slot), np.zeros(slot)
    for i in range(len(found)):
        if i > longest:
            earlier[:] = 0.0
            for k in range(first + i - longest, first + i - 1):
                merge_into(params[0], earlier, summaries[k])
        if i > 0:
            merge_into(params[0], earlier, summaries[first + i - 1])
        if size <= i <= len(found) - 1 - size:
            closed[:] = earlier
            close(params[0], closed)
            found[i] = strength(params[0], closed, later[first + i], both)
