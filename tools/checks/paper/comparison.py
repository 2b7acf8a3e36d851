"""Comparison: how unlike the segments on both sides of a moment are, at moments all over a recording.

Li and Leung's recursion asks this of the path kernel.
"""

import numpy as np
from numpy.typing import NDArray

from mossar_stream.core.kernels import compare, pad, summarise_later, summarise_pieces
from mossar_stream.settings import Settings
from mossar_stream.similarity.protocol import make_params, slot_size
from mossar_stream.skeleton import MAX_JOINTS


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
        pieces: Number of pieces; piece i begins at `starts[i]`.
        starts: (pieces,) s.

    Raises:
        ValueError: No joint, or more than a skeleton has.
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
        resolved = settings.resolved()
        joints = poses.shape[1]
        if not 1 <= joints <= MAX_JOINTS:
            raise ValueError(f"poses have 1 to {MAX_JOINTS} joints, not {joints}")
        lines = np.zeros((len(poses), 4, pad(joints)), np.float32)
        lines[:, :3, :joints] = poses.transpose(0, 2, 1)
        self._params = make_params(resolved, joints, pad(joints), root)
        self.pieces = max(1, int((times[-1] - times[0]) / piece))
        self.starts = times[0] + piece * np.arange(self.pieces)
        self._size = size
        self._summaries = np.zeros((self.pieces, slot_size(resolved, self._params)))
        self._later = np.zeros_like(self._summaries)
        times = np.ascontiguousarray(times, np.float64)
        summarise_pieces(
            self._params, lines, times, np.searchsorted(times, self.starts), self._summaries, joints
        )
        summarise_later(self._params, self._summaries, size, self._later)

    def between(self, first: int, last: int, longest: int) -> NDArray[np.float64]:
        """Return the strength between the segments beside the start of each piece.

        Args:
            first: Piece where the earlier segments begin.
            last: Piece before which the later segments end.
            longest: Of the earlier segments, pieces.

        Returns:
            (last - first + 1,) strengths; those where a segment would be shorter than `size` are -1.
        """
        found = np.full(last - first + 1, -1.0)
        scratch = np.zeros((3, self._summaries.shape[1]))
        compare(self._params, self._summaries, self._later, (first, self._size, longest), scratch, found)
        return found
