"""Who is who from picture to picture."""

import numpy as np

from mossar_adapters.oak.identities import FORGOTTEN, MAX_PEOPLE, Identities


def numbers(found):
    return [person.number if person else None for person in found]


def at(*x):
    return [np.array([value, 0.0, -3.0]) for value in x]


def test_people_are_numbered_in_the_order_of_their_first_picture():
    assert numbers(Identities().follow(at(0, 1, 2), 0.0)) == [1, 2, 3]


def test_the_nearest_pairs_find_each_other_first():
    people = Identities()
    people.follow(at(0, 1), 0.0)
    assert numbers(people.follow(at(0.9, 0.1), 0.1)) == [2, 1]
    assert numbers(people.follow(at(0.5, 0.95), 0.2)) == [1, 2]


def test_people_who_walk_past_each_other_keep_their_numbers():
    people = Identities()
    for step in range(41):
        one, two = np.array([-1 + step / 20, 0, -2.0]), np.array([1 - step / 20, 0, -3.0])
        if step % 2:
            assert numbers(people.follow([two, one], step / 24)) == [2, 1]
        else:
            assert numbers(people.follow([one, two], step / 24)) == [1, 2]


def test_nobody_is_faster_than_a_runner():
    people = Identities()
    people.follow(at(0), 0.0)
    assert numbers(people.follow(at(2), 0.1)) == [2]
    assert numbers(people.follow(at(0.3), 0.2)) == [1]


def test_a_number_is_free_again_when_its_owner_is_forgotten():
    people = Identities()
    people.follow(at(0, 5), 0.0)
    assert numbers(people.follow(at(5), FORGOTTEN)) == [2]
    assert numbers(people.follow(at(5, 9), FORGOTTEN + 0.1)) == [2, 1]


def test_people_beyond_the_most_have_no_number():
    found = numbers(Identities().follow(at(*range(MAX_PEOPLE + 2)), 0.0))
    assert found == [*range(1, MAX_PEOPLE + 1), None, None]


def test_a_clock_that_jumps_forgets_everybody():
    people = Identities()
    people.follow(at(0), 100.0)
    assert numbers(people.follow(at(3), 1.0)) == [1]


def test_somebody_alone_keeps_the_name_when_depth_slips():
    people = Identities()
    assert [who.number for who in people.follow([np.zeros(3)], 0.0)] == [1]
    assert [who.number for who in people.follow([np.array([0.0, 0.0, 1.2])], 0.04)] == [1]
    assert [who.number for who in people.follow([np.array([3.0, 0.0, 1.2])], 0.08)] == [2]
