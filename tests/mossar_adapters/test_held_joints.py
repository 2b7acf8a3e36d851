"""Hidden joints stay where they were, relative to the body centre, in whatever chunks the frames come."""

import numpy as np
import pytest

from mossar_adapters.held_joints import HeldJoints
from mossar_stream import Skeleton

BODY = Skeleton(("hip", "hand", "foot"), (-1, 0, 0))
CLOUD = Skeleton(("a", "b", "c"), (-1, 0, 0), root=-1)


def walking(count=12):
    positions = np.zeros((count, 3, 3), np.float32)
    positions[:, :, 0] = np.arange(count)[:, None]  # all walk along x
    positions[:, 1, 1] = 1.0 + 0.1 * np.arange(count)  # the hand rises
    positions[:, 2, 1] = -1.0
    return positions


def test_what_is_whole_stays_the_same_array():
    positions = walking()
    assert HeldJoints(BODY).fill(positions) is positions
    assert HeldJoints(BODY).fill(positions, np.ones((12, 3))) is positions


@pytest.mark.parametrize("chunk", [1, 5, 12])
@pytest.mark.parametrize("says", ["nan", "confidence"])
def test_a_hidden_joint_goes_along_with_the_body(chunk, says):
    positions, confidence = walking(), np.ones((12, 3), np.float32)
    positions[4:9, 1] = np.nan if says == "nan" else 99.0
    confidence[4:9, 1] = 0.0
    held = HeldJoints(BODY)
    found = np.concatenate(
        [
            held.fill(positions[at : at + chunk], confidence[at : at + chunk] if says != "nan" else None)
            for at in range(0, 12, chunk)
        ]
    )
    wanted = walking()
    wanted[4:9, 1, 1] = wanted[3, 1, 1]
    assert np.allclose(found, wanted)


def test_a_joint_that_was_never_seen_stays_where_it_was_placed_first():
    positions, confidence = walking(), np.ones((12, 3), np.float32)
    confidence[:, 1] = 0.0
    found = HeldJoints(BODY).fill(positions, confidence)
    assert np.allclose(found[:, 1, 1], positions[0, 1, 1])
    positions[:, 1] = np.nan
    assert np.isnan(HeldJoints(BODY).fill(positions)[:, 1]).all()


@pytest.mark.parametrize("skeleton", [BODY, CLOUD])
def test_a_frame_without_anybody_stays_empty_and_forgets_nothing(skeleton):
    positions = walking()
    positions[5:7] = np.nan
    positions[7:, 1] = np.nan
    found = HeldJoints(skeleton).fill(positions)
    assert np.isnan(found[5:7]).all()
    assert np.isfinite(found[7:]).all()


def test_without_a_root_the_others_are_the_centre():
    positions = walking()
    positions[6:, 0] = np.nan
    found = HeldJoints(CLOUD).fill(positions)
    assert np.isfinite(found).all()
    assert np.array_equal(found[:6], positions[:6])
