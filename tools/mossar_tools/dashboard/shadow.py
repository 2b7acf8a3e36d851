"""Shadow: the pose of an example, laid over the performer during the same move."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from mossar_stream import Example, Skeleton, joint_places
from mossar_tools.dashboard.placement import Placement, Pose

# Share of a new heading that the shadow turns to at once, so that hips that shake do not shake it.
SETTLES = 0.1
REMEMBERED = 64  # examples whose poses are at hand

Floats = NDArray[np.float64]


class Shadow:
    """Turns poses of examples to where the performer faces, and gives them the performer's size.

    Args:
        shown: Skeleton of the examples, K joints.
        streamed: Skeleton of the performer, J joints.
    """

    def __init__(self, shown: Skeleton, streamed: Skeleton) -> None:
        self.skeleton = shown
        self._streamed = streamed
        self._match = _matched(shown, streamed)  # (K,) joint of the performer, -1 for none
        self._order = _parents_first(shown)
        self._hips = [_hips(skeleton) for skeleton in (shown, streamed)]
        # m, level, from the performer's right hip to the left one; smoothed.
        self._across: Floats | None = None
        there = {ours: k for k, ours in enumerate(self._match.tolist()) if ours >= 0}
        pairs = [(there.get(a, -1), there.get(b, -1)) for a, b in streamed.bones()]
        self._bones = np.array(pairs, np.intp).reshape(-1, 2)  # of the performer, joints of the examples

    def pose(self, example: Example, progress: float, body: Pose, placement: Placement) -> Pose:
        """Return the pose of an example over the performer's.

        Args:
            example: Of the examples.
            progress: 0 to 1, along the part of the example that is followed.
            body: (J, 3) m, the performer as `placement` places it, NaN where a joint is missing.
            placement: Of the performer.

        Returns:
            (K, 3) m.
        """
        shown, _ = _followed(example, len(self.skeleton), self.skeleton.root)
        place = min(max(progress, 0.0), 1.0) * (len(shown) - 1)
        below = min(int(place), len(shown) - 2)
        now = shown[below] + (place - below) * (shown[below + 1] - shown[below])
        placed = placement.place(now).astype(np.float64)
        heading = placement.place(shown.mean(axis=0)).astype(np.float64)
        return self._anchored(self._resized(placed @ self._turn(heading, body).T, body), body)

    def strays(self, shadow: Pose, body: Pose) -> NDArray[np.float32]:
        """Return the angle between each bone of the performer and the shadow's, degrees; NaN where it has none."""
        own = np.array(self._streamed.bones(), np.intp).reshape(-1, 2)
        one = body[own[:, 1]] - body[own[:, 0]]
        other = shadow[self._bones[:, 1]] - shadow[self._bones[:, 0]]
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            angles = np.degrees(np.arccos(np.clip((one * other).sum(axis=1) / lengths, -1.0, 1.0)))
        return np.where((self._bones >= 0).all(axis=1), angles, np.nan).astype(np.float32)

    def _turn(self, heading: Floats, body: Pose) -> Floats:
        """Return the turn about the vertical that makes the example face as the performer does, (3, 3)."""
        ours, theirs = self._hips
        if ours is None or theirs is None:
            return np.eye(3)
        across = (body[theirs[0]] - body[theirs[1]])[:2].astype(np.float64)
        if np.isfinite(across).all():
            before = across if self._across is None else self._across
            self._across = before + SETTLES * (across - before)
        shown = (heading[ours[0]] - heading[ours[1]])[:2]
        if self._across is None:
            return np.eye(3)
        angle = np.arctan2(self._across[1], self._across[0]) - np.arctan2(shown[1], shown[0])
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def _resized(self, pose: Floats, body: Pose) -> Floats:
        """Return a pose with the lengths of the performer's bones, where they are known."""
        parents = np.array(self.skeleton.parents)
        known = (parents >= 0) & (self._match >= 0) & (self._match[parents] >= 0)
        along = np.where((parents >= 0)[:, None], pose - pose[parents], 0.0)
        shown = np.linalg.norm(along, axis=1)
        lengths = np.linalg.norm(body[self._match] - body[self._match[parents]], axis=1)
        known &= np.isfinite(lengths) & (shown > 1e-6)
        ratios = np.where(known, lengths / np.maximum(shown, 1e-6), 1.0)
        usual = float(np.median(ratios[known])) if known.any() else 1.0
        ratios[~known] = usual
        resized = pose * usual
        for joint in self._order:
            parent = parents[joint]
            if parent >= 0:
                resized[joint] = resized[parent] + ratios[joint] * along[joint]
        return resized

    def _anchored(self, pose: Floats, body: Pose) -> Pose:
        """Return a pose with its centre over the performer's and its feet as high."""
        theirs = self._match >= 0
        theirs &= np.isfinite(body[self._match]).all(axis=1)
        if not theirs.any():
            return pose.astype(np.float32)
        seen = body[self._match[theirs]].astype(np.float64)
        root = self.skeleton.root
        if root >= 0 and theirs[root]:
            shift = body[self._match[root]].astype(np.float64) - pose[root]
        else:
            shift = seen.mean(axis=0) - pose[theirs].mean(axis=0)
        shift[2] = seen[:, 2].min() - pose[theirs, 2].min()
        return np.asarray(pose + shift, np.float32)


@lru_cache(maxsize=REMEMBERED)
def _followed(example: Example, joints: int, root: int) -> tuple[Floats, float]:
    positions, rate = example.followed(joints, root)
    return positions.astype(np.float64), (len(positions) - 1) / rate


def seconds_of(example: Example, skeleton: Skeleton) -> float:
    """Return the duration of the followed part of an example, s."""
    return _followed(example, len(skeleton), skeleton.root)[1]


def _matched(shown: Skeleton, streamed: Skeleton) -> NDArray[np.intp]:
    """Return the same joint of another skeleton for each joint, -1 where there is none: by name, or by its meaning."""
    if shown == streamed:
        return np.arange(len(shown))
    names = {name: joint for joint, name in enumerate(streamed.names)}
    theirs = joint_places(streamed)
    found = [names.get(name, -1) for name in shown.names]
    for slot, (one, other) in joint_places(shown).items():
        there = theirs.get(slot, (-1, 0))
        if one == other and there[0] == there[1]:
            found[one] = there[0]
    return np.array(found, np.intp)


def _hips(skeleton: Skeleton) -> tuple[int, int] | None:
    places = joint_places(skeleton)
    if "left_hip" not in places or "right_hip" not in places:
        return None
    return places["left_hip"][0], places["right_hip"][0]


def _parents_first(skeleton: Skeleton) -> list[int]:
    order: list[int] = []
    known = {-1}
    while len(order) < len(skeleton):
        more = [j for j, parent in enumerate(skeleton.parents) if parent in known and j not in known]
        order += more
        known.update(more)
    return order
