"""The part of an example that is followed: without rest and parts of neighbours at its ends, and all of everything else."""

from pathlib import Path

import numpy as np
import pytest

from checks.following import SKELETON, followed, person_of
from mossar_stream import Moves, Skeleton

FPS = 30.0
ARM = Skeleton(("hip", "shoulder", "hand"), (-1, 0, 1))
PEOPLE = Path(__file__).parents[4] / "shared" / "data" / "quality" / "ui_prmd"


def arm(angles):
    """Return (n, 3, 3) m: an arm that is raised by angles, radians."""
    angles = np.asarray(angles, float)
    hand = np.stack([np.sin(angles), 1.5 - np.cos(angles), np.zeros_like(angles)], axis=1)
    still = np.array([[0.0, 1.0, 0.0], [0.0, 1.5, 0.0]])
    return np.concatenate([np.repeat(still[None], len(angles), axis=0), hand[:, None]], axis=1)


def part(angles):
    """Return how many frames are left out at the begin and at the end of an example."""
    moves = Moves(ARM)
    moves.add("raise", arm(angles), FPS)
    example = moves.examples[0]
    whole, kept = example.shown(3)[0], example.followed(3, 0)[0]
    place = next(k for k in range(len(whole)) if (whole[k : k + len(kept)] == kept).all())
    return place, len(whole) - len(kept) - place


def cycle(seconds):
    """Return angles of an arm that goes up and comes down again."""
    return 1.2 * np.sin(np.linspace(0, np.pi, round(seconds * FPS))) ** 2


def test_rest_is_left_out_but_for_a_fifth_of_a_second():
    begin, end = part([*np.zeros(45), *cycle(2.0), *np.zeros(60)])
    assert 37 <= begin <= 45
    assert 52 <= end <= 60


def test_parts_of_neighbours_are_left_out():
    three = np.concatenate([cycle(2.0)] * 3)
    begin, end = part(three[45:-45])
    assert abs(begin - 15) <= 4
    assert abs(end - 15) <= 4
    begin, end = part(three[45:-60])
    assert abs(begin - 15) <= 4
    assert end <= 4


@pytest.mark.parametrize(
    "angles",
    [
        cycle(2.0),
        cycle(0.6),
        np.concatenate([cycle(1.2), cycle(1.2)]),  # two that belong together
        1.2 * np.linspace(0, 1, 30),  # up, and no more
        np.concatenate([np.linspace(0, 1.2, 8), np.full(30, 1.2), np.linspace(1.2, 0, 8)]),  # a hold
        np.sin(np.linspace(0, 2 * np.pi, 60)),  # out to both sides
        0.3 - 0.3 * np.cos(np.linspace(0.9, 2 * np.pi + 0.9, 40)),  # a cycle that begins midway
    ],
)
def test_all_of_a_movement_is_kept(angles):
    begin, end = part(angles)
    assert begin <= 6
    assert end <= 6


def test_made_repetitions_without_rest_are_counted_whatever_lies_around_the_example():
    files = sorted(PEOPLE.glob("s*.npz"))
    if not files:
        pytest.skip("needs ../shared/data/quality/ui_prmd")
    person = person_of(files[3])
    for exercise in ("m02", "m07", "m10"):
        right = person[exercise]["right"]
        example = right[1]
        rest = np.repeat(example[:1], 15, axis=0), np.repeat(example[-1:], 15, axis=0)
        for before, after in (rest, (right[0][-15:], right[2][:15])):
            shown = np.concatenate([before, example, after])
            assert shown.shape[1] == len(SKELETON)
            done = [one for one in followed([shown], [right[0], *right[2:]]) if one.status == "done"]
            assert len(done) == 9, (exercise, len(shown))
            assert [one.count for one in done] == list(range(1, 10))
