"""Motion: the share of each joint in the motion, relative to the centre of the body."""

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton

FAST = 2.0  # m/s that counts as all a joint can do
FADE = 0.25  # s in which a joint that has stopped loses most of its colour


class Motion:
    """Speed of each joint, smoothed.

    Args:
        skeleton: J joints.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self._root = skeleton.root
        self._speed = np.zeros(len(skeleton))  # (J,) m/s
        # Time, s, and pose relative to the centre.
        self._last: tuple[float, NDArray[np.float32]] | None = None

    def take(self, time: float, pose: NDArray[np.float32]) -> None:
        """Add a pose, (J, 3) m."""
        centre = pose[self._root] if self._root >= 0 else np.nanmean(pose, axis=0)
        relative = pose - np.nan_to_num(centre)
        if self._last is not None and 0 < (step := time - self._last[0]) < 1.0:
            speed = np.nan_to_num(np.linalg.norm(relative - self._last[1], axis=1)) / step
            share = 1.0 - np.exp(-step / FADE)
            # Colour comes at once and goes slowly, so that a blow is seen.
            self._speed = np.maximum(speed, self._speed + share * (speed - self._speed))
        self._last = (time, relative)

    def shares(self) -> NDArray[np.float32]:
        """Return the share of each joint in the motion, (J,) 0..1."""
        return np.asarray(np.clip(self._speed / FAST, 0.0, 1.0) ** 0.8, np.float32)
