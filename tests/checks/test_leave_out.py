"""Weights that are chosen without a set know nothing of it."""

import re

import msgspec
import numpy as np
import pytest

from checks.leave_out import ALL, Set, around, divided, draw, leave_out, prepare
from mossar_stream.similarity.evidence import LARGEST, WEIGHTS
from mossar_tools.evaluation.performer import demo_takes


@pytest.fixture(scope="module")
def sets():
    takes = list(demo_takes("demo:?fps=30&seconds=12", 3))
    return {take.name: prepare([take]) for take in takes}


def test_what_is_left_out_has_no_part_in_the_choice(sets):
    name, other, third = sets
    without_cuts = [msgspec.structs.replace(take, cuts=[]) for take in sets[name].takes]
    changed = {name: Set(sets[name].motions, without_cuts), other: sets[other], third: sets[third]}
    found, again = (leave_out(given, drawn=6, refined=2) for given in (sets, changed))
    assert found[name].weights == again[name].weights
    assert found[other].weights != found[name].weights or found[third].weights != found[name].weights
    assert found[name].left_out > 0.0
    assert again[name].left_out == 0.0


def test_weights_in_force_are_scored_beside(sets):
    found = leave_out(sets, drawn=1, refined=0)
    for name, one in sets.items():
        assert found[name].in_force == one.f1(WEIGHTS)
    assert found[ALL].in_force == pytest.approx(np.mean([one.f1(WEIGHTS) for one in sets.values()]))


def test_sets_are_divided_by_performer():
    takes = list(demo_takes("demo:?fps=30&seconds=2", 4))
    named = [
        msgspec.structs.replace(take, name=name)
        for take, name in zip(takes, ("m1_s01", "m1_s02", "m2_s01", "other"), strict=True)
    ]
    parts = divided("own", named, re.compile(r"s\d+"))
    assert {part: [take.name for take in own] for part, own in parts.items()} == {
        "own s01": ["m1_s01", "m2_s01"],
        "own s02": ["m1_s02"],
        "own": ["other"],
    }
    assert divided("own", named, None) == {"own": named}


def test_what_is_drawn_lies_in_its_ranges():
    rng = np.random.default_rng(1)
    drawn = np.array([draw(rng) for _ in range(500)])
    assert (drawn >= 0.0).all()
    assert (drawn <= LARGEST).all()
    assert (drawn.max(axis=0) > 0.9 * np.array(LARGEST)).all()
    assert (np.array(around(WEIGHTS, rng)) >= 0.0).all()
