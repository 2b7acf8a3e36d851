"""Held joints: a joint that is hidden stays where it was, relative to the body centre, as in recognition and following.

An example of a move has all joints in all frames. If it held a joint where a stream of the same performance does not,
a performance would deviate from its own example.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton


class HeldJoints:
    """Fills in the joints of one performer, chunk by chunk.

    Args:
        skeleton: Joints are held relative to its root; without one, to the mean of the visible joints.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.skeleton = skeleton
        self._last: NDArray[Any] | None = None  # (J, 3) m, relative to the centre

    def fill(self, positions: NDArray[Any], confidence: NDArray[Any] | None = None) -> NDArray[Any]:
        """Return frames with hidden joints where they were.

        A joint that was never seen is where the sensor places it in its first frame, and missing if it does not place it. A
        frame without a centre stays as it is.

        Args:
            positions: (n, J, 3), metres; NaN where a joint is missing.
            confidence: (n, J); 0 where a joint is hidden.

        Returns:
            (n, J, 3), metres; `positions` itself if no joint is hidden.
        """
        if not len(positions):
            return positions
        missing = np.isnan(positions).any(axis=2)
        hidden = missing if confidence is None else missing | ~(confidence > 0)
        seen = np.where(hidden[:, :, None], np.nan, positions) if hidden.any() else positions
        centre = self._centre(seen, hidden)
        placed = seen - centre
        if not hidden.any():
            self._last = placed[-1]
            return positions
        before = (positions - centre)[0] if self._last is None else self._last
        before = np.where(np.isnan(before), (positions - centre)[0], before)
        latest = np.maximum.accumulate(np.where(hidden, -1, np.arange(len(positions))[:, None]), axis=0)
        held = np.take_along_axis(placed, np.maximum(latest, 0)[:, :, None], axis=0)
        held = np.where((latest < 0)[:, :, None], before, held)
        known = ~np.isnan(centre[:, 0, 0])
        if known.any():
            self._last = held[known][-1]
        filled: NDArray[Any] = (held + centre).astype(positions.dtype)
        return filled

    def _centre(self, seen: NDArray[Any], hidden: NDArray[np.bool_]) -> NDArray[Any]:
        """Return the centre of each frame, (n, 1, 3) m; NaN where nothing is known of it."""
        root = self.skeleton.root
        if root >= 0:
            return seen[:, root : root + 1]
        count = (~hidden).sum(axis=1)
        sums = np.where(hidden[:, :, None], 0.0, seen).sum(axis=1)
        with np.errstate(invalid="ignore"):
            centre: NDArray[Any] = (sums / count[:, None])[:, None]
        return centre
