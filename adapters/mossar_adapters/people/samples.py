"""Samples: the lengths of a person's bones, as medians over a fixed number of poses."""

from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Skeleton

SAMPLES: Final = 64  # poses of a person
SPACING: Final = 0.1  # s between two samples at first; doubles each time the store is full
WIDEST: Final = 3.2  # s; beyond that the oldest samples are overwritten, so 200 s are remembered
_NORMAL: Final = 1.4826  # standard deviation of a normal distribution by its median deviation
_SHORTEST: Final = 1e-3  # m; a bone that is shorter is none


class Bones:
    """The bones of a skeleton: each joint with its parent.

    Args:
        skeleton: J joints. Without parents, each joint is paired with the next.
    """

    def __init__(self, skeleton: Skeleton) -> None:
        pairs = [(joint, parent) for joint, parent in enumerate(skeleton.parents) if parent >= 0]
        pairs = pairs or [(joint, joint - 1) for joint in range(1, len(skeleton))]
        self.outer = np.array([pair[0] for pair in pairs], np.intp)
        self.inner = np.array([pair[1] for pair in pairs], np.intp)

    def lengths(self, poses: NDArray[Any]) -> NDArray[np.float64]:
        """Return log lengths (n, B) of poses (n, J, 3), NaN where a joint is missing."""
        bones = poses[:, self.outer].astype(np.float64) - poses[:, self.inner]
        length = np.sqrt(np.einsum("nbk,nbk->nb", bones, bones))
        length[length < _SHORTEST] = np.nan
        logs: NDArray[np.float64] = np.log(length)
        return logs


class Samples:
    """Poses of one person, evenly spread over the time that the person was seen.

    Args:
        joints: J.
        spacing: Between two samples at first, s.
    """

    def __init__(self, joints: int, spacing: float = SPACING) -> None:
        self.due = -np.inf  # s, when the next sample is taken
        self._poses = np.empty((SAMPLES, joints, 3), np.float32)  # metres, ring
        self._count = 0  # samples so far, not counting those that were thinned out
        self._spacing = spacing  # s
        self._summary: tuple[Bones, NDArray[np.float64], NDArray[np.float64]] | None = None  # until the next

    @classmethod
    def of(cls, poses: NDArray[np.float32], joints: int) -> Self:
        """Return samples that begin with poses (n, J, 3), metres, of an earlier run."""
        found = cls(joints)
        found._poses[: len(poses)] = poses
        found._count = len(poses)
        return found

    @property
    def poses(self) -> NDArray[np.float32]:
        """The poses, (n, J, 3) metres."""
        return self._poses[: len(self)]

    def __len__(self) -> int:
        return min(self._count, SAMPLES)

    def add(self, pose: NDArray[Any], time: float) -> None:
        """Keep a pose (J, 3), metres, seen at `time` (s)."""
        if self._count == SAMPLES and self._spacing < WIDEST:
            self._poses[: SAMPLES // 2] = self._poses[::2].copy()
            self._count //= 2
            self._spacing *= 2
        self._poses[self._count % SAMPLES] = pose
        self._count += 1
        self._summary = None
        self.due = time + self._spacing

    def shift(self, seconds: float) -> None:
        """Go on with another clock."""
        self.due += seconds

    def summary(self, bones: Bones) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the medians of the log lengths, (B,), and their variation, (B,); NaN for bones never seen."""
        if self._summary is None or self._summary[0] is not bones:
            lengths = bones.lengths(self._poses[: len(self)])
            middle = median(lengths)
            self._summary = bones, middle, _NORMAL * median(np.abs(lengths - middle))
        return self._summary[1:]


def median(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of each column, (B,), of the numbers there are; NaN for a column without any.

    Some thirty times as fast as `np.nanmedian` on few rows.
    """
    ordered = np.sort(rows, axis=0)  # NaN come last
    count = len(rows) - np.isnan(rows).sum(axis=0)
    columns = np.arange(rows.shape[1])
    low, high = np.maximum(count - 1, 0) // 2, count // 2
    middle: NDArray[np.float64] = (
        ordered[low, columns] + ordered[np.minimum(high, len(rows) - 1), columns]
    ) / 2
    middle[count == 0] = np.nan
    return middle
