import numpy as np
import pytest

from mossar_adapters.people.assignment import best_slots, left_to_others


def least(people, taken, none):
    """Try every assignment of people to slots that are not taken."""
    if not people:
        return 0.0
    first, rest = people[0], people[1:]
    ways = [cost + least(rest, taken | {slot}, none) for slot, cost in enumerate(first) if slot not in taken]
    return min([*ways, none + least(rest, taken, none)])


def some_costs(seed):
    random = np.random.default_rng(seed)
    costs = random.normal(5, 4, random.integers(1, 6, 2))
    costs[random.random(costs.shape) < 0.3] = np.inf
    return costs, float(random.choice([2.0, 6.0, 13.7, 1e3]))


@pytest.mark.parametrize("seed", range(60))
def test_what_a_choice_costs_others_is_that_of_the_best_of_all_assignments(seed):
    costs, none = some_costs(seed)
    found = left_to_others(costs, none)
    for k in range(len(costs)):
        others = np.delete(costs, k, axis=0).tolist()
        tried = np.array([least(others, {slot}, none) for slot in range(costs.shape[1])])
        np.testing.assert_allclose(found[k] - found[k, 0], tried - tried[0], atol=1e-9)


@pytest.mark.parametrize("seed", range(60))
def test_the_assignment_is_the_best(seed):
    costs, none = some_costs(seed)
    slots = best_slots(costs, none)
    given = slots[slots < costs.shape[1]]
    assert len(set(given)) == len(given), "two people in one slot"
    total = np.column_stack([costs, np.full(len(costs), none)])[np.arange(len(costs)), slots].sum()
    assert total == pytest.approx(least(costs.tolist(), set(), none))
