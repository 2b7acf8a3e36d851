"""Frames, names of performers, and times at a constant rate."""

import numpy as np
import pytest

from mossar_stream import Frames, Segmenter, Skeleton
from mossar_stream.frames import MAX_PERFORMER_NAME, constant_times, performer_name, plain_array


def test_frames_have_a_length_and_defaults():
    frames = Frames(np.zeros((5, 2, 3), np.float32), np.arange(5.0))
    assert len(frames) == 5
    assert (frames.performer, frames.confidence, frames.first_frame) == ("p1", None, None)


@pytest.mark.parametrize(
    ("name", "clean"),
    [
        ("ann", "ann"),
        ("a b/c.d", "a_b_c_d"),
        ("", "p1"),
        ("\x00\n\x1b", "p1"),
        ("Žaneta", "Žaneta"),
        ("192.168.0.7:5000", "192_168_0_7:5000"),
        ("x" * 1000, "x" * MAX_PERFORMER_NAME),
    ],
)
def test_names_are_made_fit_for_ids_and_topics(name, clean):
    assert performer_name(name) == clean
    assert performer_name(clean) == clean


def test_constant_times_count_from_the_first_frame():
    np.testing.assert_array_equal(constant_times(3, 4.0, 8), [2.0, 2.25, 2.5])
    assert len(constant_times(0, 30.0)) == 0
    for fps in (0, -30, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="fps must be a positive number"):
            constant_times(1, fps)


def test_what_is_masked_is_missing():
    masked = np.ma.masked_greater(np.arange(4, dtype=np.int64), 2)
    found = plain_array(masked, np.float32)
    assert type(found) is np.ndarray
    assert found.dtype == np.float32
    assert np.array_equal(found, [0, 1, 2, np.nan], equal_nan=True)


def test_a_masked_joint_is_held_like_one_that_is_nan():
    segmenter = Segmenter(Skeleton(("hip", "hand"), (-1, 0)), fps=30)
    segmenter.push(np.zeros((1, 2, 3)))
    segmenter.push(np.ma.masked_less(np.array([[[0.0, 0, 0], [-1, -1, -1]]]), 0))
    assert segmenter.stats["held"] == 1
