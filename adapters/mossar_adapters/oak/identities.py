"""Identities: keeps the identities of people from picture to picture by their positions."""

import math
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

MAX_PEOPLE: Final = 8
STRIDE: Final = 4.0  # m/s, about the speed of running; a faster jump means another person
SLACK: Final = 0.4  # m, for the noise of the place; less than two people can be apart
ALONE: Final = 1.5  # m; where one person was and one is, depth that slips is likelier than an exchange
FORGOTTEN: Final = 2.0  # s; longer than a pause that ends a take, so that a name is only reused in a new take


class Person(msgspec.Struct):
    """A person who was seen lately.

    Args:
        number: From 1; the lowest that is free at first sight.
        place: (3,) metres.
        time: When last seen, s.
        half_hips: (3,) metres from the left hip to the middle of the hips when both were last seen.
    """

    number: int
    place: NDArray[np.float64]
    time: float
    half_hips: NDArray[np.float64] | None = None


class Identities:
    """Keeps people apart by the nearest place.

    Example:
        >>> people = Identities()
        >>> [who.number for who in people.follow([np.zeros(3), np.ones(3)], 0.0) if who]
        [1, 2]
        >>> [who.number for who in people.follow([np.ones(3), np.zeros(3)], 0.1) if who]
        [2, 1]
    """

    def __init__(self) -> None:
        self._known: list[Person] = []

    def follow(self, places: Sequence[NDArray[np.float64]], time: float) -> list[Person | None]:
        """Return the person at each place of one picture; None for those beyond the most.

        The closest pairs of known person and place find each other first. The remaining places are new people, unless no
        known person could be mistaken for them.

        Args:
            places: (3,) metres each.
            time: Of the picture, s.
        """
        self._known = [person for person in self._known if abs(time - person.time) <= FORGOTTEN]
        found: list[Person | None] = [None] * len(places)
        free = list(self._known)
        pairs = sorted(
            (math.dist(person.place, place), person.number, i)
            for person in self._known
            for i, place in enumerate(places)
        )
        for distance, number, i in pairs:
            person = next((one for one in free if one.number == number), None)
            if person is None or found[i] or distance > SLACK + STRIDE * abs(time - person.time):
                continue
            free.remove(person)
            person.place, person.time, found[i] = places[i], time, person
        alone = len(places) == 1 and len(self._known) == 1 and bool(free)
        if alone and math.dist(free[0].place, places[0]) <= ALONE:
            free[0].place, free[0].time, found[0] = places[0], time, free[0]
        return [person or self._admit(place, time) for person, place in zip(found, places, strict=True)]

    def _admit(self, place: NDArray[np.float64], time: float) -> Person | None:
        taken = {person.number for person in self._known}
        if len(taken) == MAX_PEOPLE:
            return None
        number = next(n for n in range(1, MAX_PEOPLE + 1) if n not in taken)
        self._known.append(Person(number, place, time))
        return self._known[-1]
