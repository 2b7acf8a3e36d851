"""Placement: turns poses of any source upright, towards the viewer, onto the ground."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton
from mossar_tools.stick_figures import leftward, view_of

TURN = np.radians(24)  # the body faces the viewer and a little to the right
HEIGHT = 1.7  # m that every body is shown at
REMEMBERED = 300  # poses that the ground is found from
_UPDATES = (1, 30, 150)  # poses after which the directions are found anew

Pose = NDArray[np.float32]


class Placement:
    """Places the poses of one performer.

    Args:
        skeleton: J joints.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self._skeleton = skeleton
        self._seen = 0
        self._first: deque[Pose] = deque(maxlen=_UPDATES[-1])
        self._lowest: deque[float] = deque(maxlen=REMEMBERED)  # lowest joint of each pose, m, turned
        self._turn = np.eye(3)  # (3, 3) rows: right, away, up; scaled
        self._centre = skeleton.root

    def learn(self, pose: Pose) -> None:
        """Update the directions and the ground with a pose.

        Args:
            pose: (J, 3) m, NaN where a joint is missing.
        """
        if not np.isfinite(pose).any():
            return
        self._seen += 1
        if self._seen <= _UPDATES[-1]:
            self._first.append(pose)
        if self._seen in _UPDATES:
            self._find_directions()
        self._lowest.append(float(np.nanmin(pose @ self._turn[2])))

    def place(self, pose: Pose) -> Pose:
        """Return a pose upright on the ground, (J, 3) m."""
        turned = pose @ self._turn.T
        root = turned[self._centre] if self._centre >= 0 else np.full(3, np.nan)
        if not np.isfinite(root).all():
            present = turned[np.isfinite(turned).all(axis=1)]
            root = present.mean(axis=0) if len(present) else np.zeros(3)
        ground = min(self._lowest, default=0.0)
        return np.asarray(turned - (root[0], root[1], ground), np.float32)

    def _find_directions(self) -> None:
        poses = np.stack(self._first).astype(np.float64)
        view = view_of(self._skeleton, poses)
        upward = np.zeros(3)
        upward[view.up] = view.sign
        known = [pose for pose in poses if np.isfinite(pose).any()]
        across = leftward(known[len(known) // 2], upward, view)
        away = np.cross(upward, across)
        right = np.cos(TURN) * across + np.sin(TURN) * away
        self._turn = np.stack([right, np.cross(upward, right), upward]) * (HEIGHT / view.height)
        self._lowest.clear()
        self._lowest.extend(float(np.nanmin(pose @ self._turn[2])) for pose in known)
        self._first.clear() if self._seen == _UPDATES[-1] else None
