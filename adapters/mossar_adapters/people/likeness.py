"""Likeness: how much speaks against a newcomer being the person of a slot, by place and by the lengths of bones.

Negative log likelihoods, of which the smallest wins and differences say how clearly. Place: the distance to where the
person would be expected, which is known the worse the longer nobody has seen the person; after `LOST` not at all.
Bones: the medians of both, as shares of the length, beside what the poses of one person vary by.
"""

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mossar_adapters.people.body import Body
from mossar_adapters.people.samples import Bones, Samples, median
from mossar_stream import Skeleton

LOST: Final = 2.0  # s after which the place says nothing any more
# The rest was fitted with `python -m checks.people`, on scenes of other seeds than those of docs/people.md.
_NEAR: Final = 0.08  # m that a place is off by at once
_WANDER: Final = 0.7  # m/s that is added while nobody sees the person
_REACH: Final = 0.4  # m
_STRIDE: Final = 4.0  # m/s; a body farther away than these two allow is another person
_ANYWHERE: Final = 0.93  # of a newcomer on a stage of 4 m by 4 m, as a density
_INDEPENDENT: Final = 8.0  # bones that count as independent of each other
_STRANGE: Final = (
    1.1  # what speaks against a stranger for each of them; the same person has 0.6 in the median
)
_POSTURE: Final = 0.04  # that the median length of a bone differs by from one posture of a person to the next
_BLUR: Final = 0.015  # m that the length of any bone is off by, which matters for short ones
_CAP: Final = 4.5  # for one bone; three times the noise
_FEW: Final = 3  # fewest samples for an estimate of the noise
_NOISE: Final = 0.07  # before that


class Likeness:
    """Compares people by their bones; knows the bones of a few skeletons."""

    def __init__(self) -> None:
        self._bones: dict[Skeleton, Bones] = {}

    def against_place(self, body: Body, pose: NDArray[Any], time: float) -> float:
        """Return what the place says against a pose being the body's; infinite if nobody gets there in time."""
        gap = time - body.time
        if gap > LOST:
            return _spread(LOST) + 0.5
        distance = body.distance(pose, time)
        if not distance <= _REACH + _STRIDE * gap:
            return float("inf")
        wide = _NEAR + _WANDER * gap
        return distance * distance / (2 * wide * wide) + _spread(gap)

    def against_stranger(self) -> float:
        """Return what speaks against somebody who was never here."""
        return _ANYWHERE + _INDEPENDENT * _STRANGE

    def against_bones(
        self, body: Body, samples: Samples, skeleton: Skeleton | None, bodies: Iterable[Body]
    ) -> float:
        """Return what the lengths of bones say against a newcomer being the body's person.

        Args:
            body: Of the slot.
            samples: Of the newcomer.
            skeleton: Of the newcomer.
            bodies: All bodies that the noise is estimated from.
        """
        if skeleton is None or body.skeleton != skeleton or not len(samples) or not len(body.samples):
            return _INDEPENDENT * _STRANGE  # says nothing
        bones = self._bones_of(skeleton)
        off = samples.summary(bones)[0] - body.samples.summary(bones)[0]
        share = off / self._noise(bones, skeleton, bodies)
        share = share[~np.isnan(share)]
        if not len(share):
            return _INDEPENDENT * _STRANGE
        return _INDEPENDENT * float(np.minimum(share * share / 2, _CAP).mean())

    def _bones_of(self, skeleton: Skeleton) -> Bones:
        known = self._bones.get(skeleton)
        if known is None:
            if len(self._bones) >= 8:
                del self._bones[next(iter(self._bones))]
            known = self._bones[skeleton] = Bones(skeleton)
        return known

    def _noise(self, bones: Bones, skeleton: Skeleton, bodies: Iterable[Body]) -> NDArray[np.float64]:
        """Return what each bone of one person varies by, as a share, (B,)."""
        known = [b.samples for b in bodies if b.skeleton == skeleton and len(b.samples) >= _FEW]
        if not known:
            return np.full(len(bones.outer), _NOISE)
        varied = median(np.array([samples.summary(bones)[1] for samples in known]))
        lengths = np.exp(median(np.array([samples.summary(bones)[0] for samples in known])))
        blur = _BLUR / lengths
        varied[np.isnan(varied)] = blur[np.isnan(blur)] = _NOISE
        noise: NDArray[np.float64] = np.sqrt(varied * varied + blur * blur + _POSTURE * _POSTURE)
        return noise


def _spread(gap: float) -> float:
    return 2 * float(np.log(_NEAR + _WANDER * gap))
