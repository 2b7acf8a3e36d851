"""Following: the people in a video or before a camera, from picture to picture.

A person who was found is followed by the landmarks alone: those of one picture give the region in the next. The
detector runs only while there is room for another person.
"""

import math
from collections.abc import Sequence
from typing import Final

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from mossar_adapters.pose.detector import Detector
from mossar_adapters.pose.landmarks import Landmarker, Landmarks
from mossar_adapters.pose.region import Region
from mossar_adapters.pose.smoothing import PICTURE, REGION, WORLD, OneEuro
from mossar_adapters.pose.travel import Travel
from mossar_adapters.pose.types import JOINTS, MAX_PEOPLE, SKELETON, Body
from mossar_adapters.pose.weights import Weights

_AXES: Final = (1.0, -1.0, -1.0)  # the maker's y points down and z away
# The network places every joint, seen or not. A joint that was hidden for longer is missing rather than invented.
_VISIBLE: Final = 0.5  # of visibility
_HIDDEN: Final = 0.5  # s
_LEAST: Final = 0.001  # confidence of a present joint; 0 is missing
_TRUNK: Final = 0.2  # of the size, half a metre: the part of followed people that is painted over
_REMEMBERED: Final = 2.0  # s after which the number of a lost person is free
# s between two searches for further people while a person is followed; they do not slow down a single person.
_LOOK: Final = 0.5


class Estimator:
    """Estimates where the joints of people are.

    Args:
        weights: Files of the networks.
        people: Most people to follow, 1 to 4.
        smooth: Whether to filter the joints of single pictures; see `smoothing.py`.
    """

    def __init__(self, weights: Weights, people: int = 1, *, smooth: bool = True) -> None:
        if not 1 <= people <= MAX_PEOPLE:
            raise ValueError(f"people must be 1 to {MAX_PEOPLE}, not {people}")
        self._detector = Detector(weights.detector)
        self._landmarker = Landmarker(weights.landmarks)
        self._people, self._smooth = people, smooth
        self._followed: list[_Person] = []
        self._lost: list[_Absent] = []
        self._looked = -math.inf  # s

    def estimate(self, picture: NDArray[np.uint8], time: float) -> list[Body]:
        """Return the people in a picture, by their numbers.

        Args:
            picture: (h, w, 3), BGR.
            time: s; later than that of the picture before.
        """
        self._find(picture, time)
        bodies = [self._body(person, picture, time) for person in self._followed]
        gone = [person for person, body in zip(self._followed, bodies, strict=True) if body is None]
        self._drop([*gone, *_twice(self._followed)], time)
        numbers = {person.number for person in self._followed}
        return sorted(
            (body for body in bodies if body is not None and body.number in numbers),
            key=lambda body: body.number,
        )

    def forget(self) -> None:
        """Stop following all people; the next picture is independent of the last."""
        self._followed, self._lost, self._looked = [], [], -math.inf

    def _find(self, picture: NDArray[np.uint8], time: float) -> None:
        """Follow people who are not followed yet, if there is room for them."""
        room = self._people - len(self._followed)
        if room == 0 or (self._followed and 0 <= time - self._looked < _LOOK):
            return
        self._looked = time
        if self._followed:
            picture = _without(picture, [person.region for person in self._followed])
        while room:
            known = [person.region for person in self._followed]
            new = [
                region
                for region in self._detector.find(picture, room)
                if not any(region.is_of_same_person(other) for other in known)
            ]
            for region in new:
                self._followed.append(_Person(self._number(region, time), region, self._smooth))
            room -= len(new)
            if not (room and new):
                return
            picture = _without(picture, new)

    def _number(self, region: Region, time: float) -> int:
        """Return the number of the person in a region: that of the nearest lost lately, else the lowest that is free."""
        self._lost = [absent for absent in self._lost if 0 <= time - absent.time <= _REMEMBERED]
        near = sorted(
            self._lost, key=lambda absent: math.hypot(absent.region.x - region.x, absent.region.y - region.y)
        )
        if near:
            self._lost.remove(near[0])
            return near[0].number
        taken = {person.number for person in self._followed}
        return next(number for number in range(1, self._people + 1) if number not in taken)

    def _body(self, person: "_Person", picture: NDArray[np.uint8], time: float) -> Body | None:
        found = self._landmarker.read(picture, person.region, is_new=person.is_new)
        return None if found is None else person.follow(found, time, picture.shape[:2])

    def _drop(self, people: "Sequence[_Person]", time: float) -> None:
        for person in people:
            if person in self._followed:
                self._followed.remove(person)
                self._lost = [absent for absent in self._lost if absent.number != person.number]
                self._lost.append(_Absent(person.number, person.region, time))


class _Absent(msgspec.Struct, frozen=True):
    """A lost person: number, place, and time, s."""

    number: int
    region: Region
    time: float


class _Person:
    """A followed person.

    Args:
        number: From 1.
        region: Where to look.
        smooth: Whether to filter.
    """

    def __init__(self, number: int, region: Region, smooth: bool) -> None:
        self.number, self.region = number, region
        self.is_new = True
        self._travel = Travel()
        self._seen = np.full(JOINTS, -math.inf)  # s, when each joint was last visible
        self._filters = (OneEuro(*WORLD), OneEuro(*PICTURE), OneEuro(*REGION)) if smooth else None

    def follow(self, found: Landmarks, time: float, size: tuple[int, int]) -> Body:
        """Return the body in a picture, and look for it there in the next.

        Args:
            found: In the picture.
            time: s.
            size: Height and width of the picture, pixels.
        """
        if self._filters is not None:
            world, pixels, ends = self._filters
            scale = 1.0 / max(self.region.size, 1.0)  # speeds in the picture are those of bodies, near or far
            found = Landmarks(
                np.vstack(
                    (pixels(found.pixels[:JOINTS], time, scale), ends(found.pixels[JOINTS:], time, scale))
                ),
                world(found.world, time),
                found.visible,
            )
        self.region = found.next_region()
        self.is_new = False
        hidden = self._hidden(found.visible, time)
        place = found.world + self._travel.hips(found, time, size)
        return Body(
            self.number,
            (place * _AXES).astype(np.float32),
            np.where(hidden, 0.0, np.maximum(found.visible, _LEAST)).astype(np.float32),
            found.pixels[:JOINTS].astype(np.float32),
        )

    def _hidden(self, visible: NDArray[np.float64], time: float) -> NDArray[np.bool_]:
        """Return the joints that were not visible over the last 0.5 s; the body centre always counts as seen."""
        self._seen[(visible >= _VISIBLE) | (self._seen == -math.inf)] = time
        hidden: NDArray[np.bool_] = time - self._seen > _HIDDEN
        hidden[SKELETON.root] = False
        return hidden


def _without(picture: NDArray[np.uint8], regions: Sequence[Region]) -> NDArray[np.uint8]:
    """Return a picture in which the trunks and heads of people are painted over.

    The detector was made for one person: of several it may see the most conspicuous one alone.
    """
    picture = picture.copy()
    for region in regions:
        middle, end = (tuple(round(float(np.clip(v, -1e4, 1e4))) for v in point) for point in region.points())
        cv2.line(picture, middle, end, (0, 0, 0), max(1, min(round(_TRUNK * region.size), 1000)))
    return picture


def _twice(people: "Sequence[_Person]") -> "list[_Person]":
    """Return the entries that are the same person as an earlier one in the list."""
    return [
        person
        for k, person in enumerate(people)
        if any(person.region.is_of_same_person(other.region) for other in people[:k])
    ]
