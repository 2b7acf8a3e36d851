"""Likeness: the evidence against a newcomer being the person of a slot, by place and by the lengths of bones.

Negative log likelihoods: the smallest wins, and the difference is its certainty. Place: the distance from the expected
place, which becomes less certain the longer the person is out of sight, and unknown after `LOST`. Bones: the medians of
both, as shares of the length, beside their variation over the poses of one person.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.people.body import PAUSE, Body, centre
from mossar_adapters.people.newcomer import Newcomer
from mossar_adapters.people.samples import Bones, median
from mossar_stream import Skeleton

LOST: Final = 2.0  # s after which the place is no evidence any more
# The rest was fitted with `python -m checks.people`, on scenes of other seeds than those of docs/people.md.
_NEAR: Final = 0.08  # m, error of a place at once
_WANDER: Final = 0.7  # m/s, added to it while the person is out of sight
_REACH: Final = 0.4  # m
_AHEAD: Final = 0.6  # s that a person is expected to walk on
_STRIDE: Final = 4.0  # m/s; a body farther away than these two allow is another person
_ANYWHERE: Final = 0.93  # of a newcomer on a stage of 4 m by 4 m, as a density
_INDEPENDENT: Final = 8.0  # bones that count as independent of each other
# Evidence against a stranger for each of them; the same person has 0.6 in the median.
_STRANGE: Final = 1.1
_POSTURE: Final = 0.04  # that the median length of a bone differs by from one posture of a person to the next
_BLUR: Final = 0.015  # m that the length of any bone is off by, which matters for short ones
_CAP: Final = 4.5  # for one bone; three times the noise
_FEW: Final = 3  # fewest samples for an estimate of the noise
_NOISE: Final = 0.07  # before that


class Likeness:
    """Compares people by their bones; knows the bones of a few skeletons."""

    def __init__(self) -> None:
        self._bones: dict[Skeleton, Bones] = {}

    def against_stranger(self) -> float:
        """Return the evidence against a new person."""
        return _ANYWHERE + _INDEPENDENT * _STRANGE

    def against(
        self, newcomers: Sequence[Newcomer], bodies: Sequence[Body], owners: Sequence[Body | None]
    ) -> NDArray[np.float64]:
        """Return the evidence against each newcomer being each body's person, (n, m); infinite if it cannot be.

        Args:
            newcomers: n of them.
            bodies: m of them, the noise of whose bones is estimated from all.
            owners: The body that has each newcomer's id; for it, a place out of reach is weak evidence.
        """
        places = _Places(bodies)
        found = np.array([places.against(one) for one in newcomers])
        for row, one, owner in zip(found, newcomers, owners, strict=True):
            if owner is not None and one.first - owner.time <= PAUSE:
                row[places.farther(one, owner)] = np.inf  # it leaps to where another was, if it is another
            if owner is not None and one.first - owner.time <= LOST:
                row[owner.number] = min(row[owner.number], self.against_stranger())
        for skeleton in {one.skeleton for one in newcomers}:
            rows = [k for k, one in enumerate(newcomers) if one.skeleton == skeleton]
            found[rows] += self._against_bones([newcomers[k] for k in rows], skeleton, bodies)
        return found

    def _against_bones(
        self, newcomers: Sequence[Newcomer], skeleton: Skeleton | None, bodies: Sequence[Body]
    ) -> NDArray[np.float64]:
        """Return the evidence of the lengths of bones against newcomers of one skeleton, (n, m)."""
        found = np.full((len(newcomers), len(bodies)), _INDEPENDENT * _STRANGE)  # no evidence
        alike = [k for k, body in enumerate(bodies) if body.skeleton == skeleton and len(body.samples)]
        if skeleton is None or not alike:
            return found
        bones = self._bones_of(skeleton)
        known = np.array([bodies[k].samples.summary(bones)[0] for k in alike])
        noise = self._noise(bones, skeleton, bodies)
        for row, one in zip(found, newcomers, strict=True):
            share = (one.samples.summary(bones)[0] - known) / noise
            missing = np.isnan(share)
            clipped = np.minimum(np.where(missing, 0.0, share * share / 2), _CAP).sum(axis=1)
            seen = share.shape[1] - missing.sum(axis=1)
            row[alike] = np.where(seen, _INDEPENDENT * clipped / np.maximum(seen, 1), row[alike])
        return found

    def _bones_of(self, skeleton: Skeleton) -> Bones:
        known = self._bones.get(skeleton)
        if known is None:
            if len(self._bones) >= 8:
                del self._bones[next(iter(self._bones))]
            known = self._bones[skeleton] = Bones(skeleton)
        return known

    def _noise(self, bones: Bones, skeleton: Skeleton, bodies: Sequence[Body]) -> NDArray[np.float64]:
        """Return the variation of each bone of one person, as a share, (B,)."""
        known = [b.samples for b in bodies if b.skeleton == skeleton and len(b.samples) >= _FEW]
        if not known:
            return np.full(len(bones.outer), _NOISE)
        varied = median(np.array([samples.summary(bones)[1] for samples in known]))
        lengths = np.exp(median(np.array([samples.summary(bones)[0] for samples in known])))
        blur = _BLUR / lengths
        varied[np.isnan(varied)] = blur[np.isnan(blur)] = _NOISE
        noise: NDArray[np.float64] = np.sqrt(varied * varied + blur * blur + _POSTURE * _POSTURE)
        return noise


class _Places:
    """Expected places of people, so that newcomers can be compared with all of them at once.

    Args:
        bodies: m of them.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies
        self._times = np.array([body.time for body in bodies])  # s, when last seen
        self._velocities = np.array([body.velocity() if body.used else np.zeros(3) for body in bodies])
        self._middles = np.array([centre(body.pose) for body in bodies])  # (m, 3) metres

    def against(self, newcomer: Newcomer) -> NDArray[np.float64]:
        """Return the evidence of the place against a newcomer being each body, (m,); infinite if it is out of reach."""
        gaps = np.maximum(newcomer.first - self._times, 0.0)
        moved = self._moved(gaps)
        distances = self._distances(newcomer, moved)
        for k in np.flatnonzero(gaps <= PAUSE).tolist():
            if len(self._bodies[k].pose) == len(newcomer.seen):
                distances[k] = _apart(newcomer.seen, self._bodies[k].pose + moved[k])
        lately = np.minimum(gaps, LOST)
        wide = _NEAR + _WANDER * lately
        found = distances * distances / (2 * wide * wide) + _spread(lately)
        found[~(distances <= _REACH + _STRIDE * gaps)] = np.inf
        return np.asarray(np.where(gaps > LOST, _spread(LOST) + 0.5, found))

    def farther(self, newcomer: Newcomer, owner: Body) -> NDArray[np.bool_]:
        """Return the bodies that are expected farther from a newcomer than the one that has its id, (m,).

        A person who was lost long ago may be anywhere, but not in the place of another.
        """
        gaps = np.maximum(newcomer.first - self._times, 0.0)
        distances = np.where(gaps > LOST, _REACH, self._distances(newcomer, self._moved(gaps)))
        return np.asarray(distances > distances[self._bodies.index(owner)])

    def _moved(self, gaps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the expected way of bodies that were not seen for so long (s), (m, 3) metres."""
        return self._velocities * np.minimum(gaps, _AHEAD)[:, None]

    def _distances(self, newcomer: Newcomer, moved: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distances of a newcomer's middle from those of the moved bodies, (m,) metres."""
        away = centre(newcomer.seen) - (self._middles + moved)
        return np.asarray(np.sqrt(np.einsum("mk,mk->m", away, away)))


def _apart(pose: NDArray[Any], there: NDArray[Any]) -> float:
    """Return the distance of the joints of two poses, root mean square, m; NaN if none is in both."""
    steps = pose - there
    squares = np.einsum("jk,jk->j", steps, steps)
    squares = squares[~np.isnan(squares)]  # ten times as fast as `np.nanmean` on few numbers
    return float(np.sqrt(squares.sum() / len(squares))) if len(squares) else float("nan")


def _spread(gaps: Any) -> Any:
    return 2 * np.log(_NEAR + _WANDER * gaps)
