import numpy as np
import pytest

from mossar_adapters.receiving.batch import MAX_PERFORMERS, Batch
from mossar_adapters.receiving.pose import Pose
from mossar_adapters.receiving.recent import SILENT
from mossar_adapters.source import Departure, Meta
from mossar_stream import FrameError, Frames, Skeleton

SKELETON = Skeleton(("hip", "hand"), (-1, 0))


def pose(performer="p1", arrival=0.0, joints=2, **fields):
    return Pose(performer, np.zeros((joints, 3)), arrival, **fields)


def test_who_moves_is_not_forgotten_in_a_flood_of_names():
    batch = Batch()
    batch.put(Meta("ann", SKELETON))
    refused = 0
    for k in range(2000):
        now = k * 0.001
        batch.put(pose("ann", now))
        try:
            batch.put(pose(f"stranger{k}", now, 5))
        except FrameError:
            refused += 1
    assert refused == 2000 - MAX_PERFORMERS + 1
    assert [item for item in batch.take() if isinstance(item, Meta) and item.performer == "ann"] == [
        Meta("ann", SKELETON)
    ]
    batch.put(pose("ann", 10.0))
    assert [type(item) for item in batch.take()] == [Frames], "announced once, with its own skeleton"


def test_a_performer_without_a_meta_has_the_skeleton_that_was_described_last_for_as_many_joints():
    batch, other = Batch(), Skeleton(("left", "right"), (-1, 0))
    batch.put(Meta("ann", SKELETON, 60.0))
    batch.put(pose("bob"))
    batch.put(pose("three", joints=3))
    batch.put(Meta("cleo", other))
    batch.put(pose("dan"))
    batch.put(Meta("bob", other))
    metas = [item for item in batch.take() if isinstance(item, Meta)]
    assert [one for one in metas if one.performer == "bob"] == [
        Meta("bob", SKELETON, 60.0),
        Meta("bob", other),
    ]
    assert [one for one in metas if one.performer == "dan"] == [Meta("dan", other)]
    assert [(one.performer, len(one.skeleton)) for one in metas if one.assumed] == [("three", 3)]


def test_who_was_silent_makes_room():
    batch = Batch()
    for k in range(MAX_PERFORMERS):
        batch.put(pose(f"p{k}", k * 0.001))
    with pytest.raises(FrameError, match="all of them move; new is refused"):
        batch.put(pose("new", 1.0))
    batch.put(pose("new", SILENT + 0.001))
    assert len(batch._lines) == MAX_PERFORMERS
    found = batch.take()
    assert sum(len(item) for item in found if isinstance(item, Frames)) == MAX_PERFORMERS + 1, (
        "nothing is lost"
    )


def test_frames_with_and_without_confidence_do_not_share_a_chunk():
    batch = Batch(fps=10.0)
    batch.put(pose(confidence=np.array([2.0, np.nan])))
    batch.put(pose())
    _, first, second = batch.take()
    assert first.confidence.tolist() == [[1.0, 0.0]]
    assert second.confidence is None
    assert [first.times[0], second.times[0]] == [0.0, 0.1]


def test_what_does_not_fit_is_refused_and_what_is_too_far_is_missing():
    batch = Batch()
    batch.put(Meta("p1", SKELETON))
    with pytest.raises(FrameError, match="3 joints does not fit the skeleton: it has 2"):
        batch.put(pose(joints=3))
    with pytest.raises(FrameError, match="is no time"):
        batch.put(pose(time=float("nan")))
    far = pose()
    far.positions[1] = 1e39  # more than float32 holds
    batch.put(far)
    positions = batch.take()[1].positions
    assert np.isfinite(positions[0, 0]).all()
    assert np.isnan(positions[0, 1]).all()


def test_who_was_never_announced_does_not_leave():
    batch = Batch()
    batch.put(Departure("p1", "lost user"))
    assert batch.take() == []


def steps(changes):
    """Return the steps of time of a person who gets new ids at some frames; frames come late by some milliseconds."""
    rng = np.random.default_rng(5)
    batch, times = Batch(), []
    for k in range(150):
        arrival = k / 15 + rng.exponential(0.006)
        ident = f"p{sum(k >= change for change in changes)}"
        batch.put(Pose(ident, rng.normal(size=(2, 3)), arrival))
        times += [time for item in batch.take() if isinstance(item, Frames) for time in item.times]
    return np.diff(times)[60:]


def test_a_new_id_goes_on_with_the_times_of_its_sender():
    assert np.array_equal(steps([70, 90, 120]), steps([]))


def test_a_new_id_after_a_pause_begins_anew():
    batch = Batch()
    for k in range(30):
        batch.put(Pose("a", np.zeros((2, 3)), k / 15))
    batch.put(Pose("b", np.zeros((2, 3)), 9.0))
    frames = [item for item in batch.take() if isinstance(item, Frames)]
    assert frames[-1].times.tolist() == [9.0]
