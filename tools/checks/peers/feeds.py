"""Feeds: input of detectors, made from positions frame by frame, in numpy as a user would write it."""

from collections import deque
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Settings
from mossar_tools.evaluation.mossar import at_level_of
from mossar_tools.evaluation.takes import Take

MARGIN = 1e-6  # s, for the rounding of timestamps, as in the core
FeedName = Literal["curve", "poses", "positions"]


class Feed(Protocol):
    """Makes samples from frames."""

    def sample(self, positions: NDArray[np.float32], time: float) -> NDArray[Any]:
        """Return the sample of the next frame.

        Args:
            positions: (J, 3) m.
            time: s.
        """


class CurveFeed:
    """Equation 1, plainly: the mean joint speed over the window of the level, (1,) m/s.

    Args:
        take: Says level, centre and joints.
    """

    def __init__(self, take: Take) -> None:
        self._window = at_level_of(take, Settings(similarity="likelihood")).resolved().window or 1.0
        self._poses = PoseFeed(take)
        self._before: NDArray[np.float32] | None = None
        self._steps: deque[tuple[float, float]] = deque()
        self._sum = 0.0
        self._per = 1.0 / (self._window * len(take.skeleton))

    def sample(self, positions: NDArray[np.float32], time: float) -> NDArray[Any]:
        """See `Feed`."""
        now = self._poses.sample(positions, time)
        if self._before is not None:
            way = (now - self._before).reshape(-1, 3)
            step = float(np.sqrt((way * way).sum(axis=1)).sum())
            self._steps.append((time, step))
            self._sum += step
        self._before = now
        while self._steps and self._steps[0][0] <= time - (self._window - MARGIN):
            self._sum -= self._steps.popleft()[1]
        return np.array([self._sum * self._per])


class PoseFeed:
    """Coordinates relative to the centre, (3 J,) m; 0 where a joint is missing.

    Args:
        take: Says which joint is the centre.
    """

    def __init__(self, take: Take) -> None:
        self._root = take.skeleton.root

    def sample(self, positions: NDArray[np.float32], time: float) -> NDArray[Any]:  # noqa: ARG002
        """See `Feed`."""
        center = positions[self._root] if self._root >= 0 else positions.mean(axis=0)
        local: NDArray[np.float32] = (positions - center).reshape(-1)
        return local if np.isfinite(local.sum()) else np.nan_to_num(local)


class PositionFeed:
    """Unchanged positions, the input of ours."""

    def sample(self, positions: NDArray[np.float32], time: float) -> NDArray[Any]:  # noqa: ARG002
        """See `Feed`."""
        return positions


def feed_of(name: FeedName, take: Take) -> Feed:
    """Return a feed that begins with a take."""
    if name == "positions":
        return PositionFeed()
    return CurveFeed(take) if name == "curve" else PoseFeed(take)
