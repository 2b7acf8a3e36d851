"""Assignment: people and slots, each person in a slot of its own or in none, so that the sum of the costs is least.

The assignment is found by shortest augmenting paths (Jonker and Volgenant, Computing 38, 1987), n² · m steps for n
people and m slots. The cost of one choice for the others is the length of a shortest path, too: the person in
that slot goes to another, and so on, until the slot is reached that the choice has left (Floyd and Warshall, m³ steps).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def left_to_others(costs: NDArray[np.float64], none: float) -> NDArray[np.float64]:
    """Return the rise of the others' cost over the best assignment if a person takes a slot.

    Args:
        costs: (n, m), of each person in each slot; infinite where it cannot be.
        none: Of a person without a slot.

    Returns:
        (n, m); the differences within a row count.

    Example:
        >>> left_to_others(np.array([[1.0, 5.0], [2.0, 3.0]]), none=9.0)
        array([[ 0., -1.],
               [ 4.,  0.]])
    """
    columns = best_slots(costs, none)
    return _ways(costs, none, columns)[:-1, columns].T


def best_slots(costs: NDArray[np.float64], none: float) -> NDArray[np.intp]:
    """Return the slot of each person in the best assignment, (n,); m for none."""
    count, slots = costs.shape
    wide = np.column_stack([costs, np.full(count, none)])
    rows, columns = np.zeros(count), np.zeros(slots + 1)  # prices of people and slots
    holder = np.full(slots + 1, -1)  # the last column is never full
    found = np.full(count, -1)
    for person in range(count):
        _augment(person, wide, rows, columns, holder, found)
    return found


def _augment(
    person: int,
    wide: NDArray[np.float64],
    rows: NDArray[np.float64],
    columns: NDArray[np.float64],
    holder: NDArray[Any],
    found: NDArray[Any],
) -> None:
    """Give one more person a slot; others change theirs as far as that is better for all."""
    nearest = np.full(len(columns), np.inf)  # length of the path to each slot
    before = np.full(len(columns), person)
    is_open = np.ones(len(columns), bool)
    length, one, passed = 0.0, person, [person]
    while True:
        reach = length + wide[one] - rows[one] - columns
        nearer = (reach < nearest) & is_open
        nearest[nearer], before[nearer] = reach[nearer], one
        slot = int(np.where(is_open, nearest, np.inf).argmin())
        length, is_open[slot] = float(nearest[slot]), False
        if holder[slot] < 0:
            break
        one = int(holder[slot])
        passed.append(one)
    rows[person] += length
    for other in passed[1:]:
        rows[other] += length - nearest[found[other]]
    closed = ~is_open
    columns[closed] -= length - nearest[closed]
    while slot >= 0:
        one = int(before[slot])
        if slot < len(columns) - 1:
            holder[slot] = one
        found[one], slot = slot, (int(found[one]) if one != person else -1)


def _ways(costs: NDArray[np.float64], none: float, columns: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the costs of freeing one slot if another is left, (m + 1, m + 1); the last stands for none.

    From a slot its person goes to another one, or to none. An empty slot is free already, and one that is left may
    stay empty.
    """
    slots = costs.shape[1]
    wide = np.column_stack([costs, np.full(len(costs), none)])
    ways = np.full((slots + 1, slots + 1), np.inf)
    ways[np.setdiff1d(np.arange(slots), columns), slots] = 0.0
    ways[slots] = 0.0
    for one, slot in enumerate(columns):
        np.minimum(ways[slot], wide[one] - wide[one, slot], out=ways[slot])
    for slot in range(slots + 1):
        np.minimum(ways, ways[:, slot, None] + ways[slot], out=ways)
    np.fill_diagonal(ways, 0.0)
    return ways
