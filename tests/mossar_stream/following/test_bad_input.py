"""Bad input: examples that cannot be followed are refused in one line; gaps, holes and noise end nothing but a performance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mossar_stream import FollowEvent, FrameError, Moves, MovesError, Segmenter, Skeleton, SnapshotError
from mossar_stream.core.kernels import follow_cell_parts, follow_memory_parts
from mossar_stream.moves.parts import parts_of

from ..segmenter.test_steps import Striking  # noqa: TID252 - as the tests beside it
from .test_following import (
    FPS,
    ORDER,
    PERSON,
    STANDING,
    events_of,
    followed,
    lines_of,
    moves,
    performed,
    take,
)

__all__ = ["moves", "take"]  # fixtures


def test_an_example_of_ten_minutes_is_refused_by_name_and_kept_for_recognition():
    moves = Moves(PERSON)
    moves.add("slow", np.tile(performed("circle_left", seconds=20.0), (30, 1, 1)), FPS)
    with pytest.raises(
        MovesError,
        match="the movement in an example of 'slow' takes 600 s; what is followed takes at most 60 s",
    ):
        Segmenter(PERSON, moves=moves, follow=True)
    assert Segmenter(PERSON, moves=moves).moves.names == ("slow",)


def test_long_examples_are_followed_coarser():
    moves = Moves(PERSON)
    moves.add("slow", performed("circle_left", seconds=24.0), FPS)
    still = np.repeat(STANDING[None], 60, axis=0)
    frames = np.concatenate([still, performed("circle_left", seconds=20.0), still]).astype(np.float32)
    segmenter = Segmenter(PERSON, moves=moves, follow=("slow",))
    done = followed(events_of(segmenter, frames, np.arange(len(frames)) / FPS, 64), "done")
    assert [event.count for event in done] == [1]
    assert abs(done[0].start - 2.0) < 1.5
    assert abs(done[0].time - 22.0) < 1.5
    assert 1.0 < done[0].tempo < 1.4


def test_other_skeletons_are_followed_if_they_have_the_joints(moves, take):
    positions, times, truth = take
    order = np.random.default_rng(2).permutation(len(PERSON))
    place = {int(joint): k for k, joint in enumerate(order)}
    parents = tuple(place.get(PERSON.parents[j], -1) for j in order)
    other = Skeleton(tuple(PERSON.names[j] for j in order), parents, place[0])
    done = followed(
        events_of(Segmenter(other, moves=moves, follow=True), positions[:, order], times, 32), "done"
    )
    assert [event.name for event in done] == [name for name, _, _ in truth]
    with pytest.raises(FrameError, match="joints that the stream does not have"):
        Segmenter(Skeleton(("a", "b"), (-1, 0)), moves=moves, follow=True)


def test_a_performer_who_has_turned_is_followed_alike(moves, take):
    positions, times, truth = take
    c, s = np.cos(1.9), np.sin(1.9)
    turned = positions @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]], np.float32)
    done = followed(events_of(Segmenter(PERSON, moves=moves, follow=True), turned, times, 32), "done")
    assert [event.name for event in done] == [name for name, _, _ in truth]
    assert max(event.deviation for event in done) < 4


def test_another_axis_may_point_upwards(moves, take):
    from mossar_stream import Settings

    positions, times, truth = take
    shown = Moves(PERSON)
    for example in moves.examples:
        shown.add(example.name, example.shown(len(PERSON))[0][..., [2, 0, 1]], FPS)
    segmenter = Segmenter(PERSON, Settings(up="z"), moves=shown, follow=True)
    done = followed(events_of(segmenter, positions[..., [2, 0, 1]], times, 32), "done")
    assert [event.name for event in done] == [name for name, _, _ in truth]


def test_a_gap_within_a_performance_gives_it_up(moves, take):
    positions, times, truth = take
    middle = (truth[0][1] + truth[0][2]) // 2
    keep = np.r_[0:middle, middle + 12 : len(times)]
    events = followed(
        events_of(Segmenter(PERSON, moves=moves, follow=True), positions[keep], times[keep], 16)
    )
    events = [event for event in events if event.name == "punch_left"]
    assert events[0].status == "begun"
    assert [event.status for event in events if event.id == events[0].id][-1] == "left"
    assert [event.count for event in events if event.status == "done"] == [1, 2]


def test_missing_joints_and_frames_do_no_harm(moves, take):
    positions, times, truth = take
    rng = np.random.default_rng(4)
    holes = positions.copy()
    holes[rng.random(holes.shape[:2]) < 0.02] = np.nan
    holes[200:204] = np.nan
    keep = rng.random(len(times)) > 0.05
    done = followed(
        events_of(Segmenter(PERSON, moves=moves, follow=True), holes[keep], times[keep], 16), "done"
    )
    assert [event.name for event in done] == [name for name, _, _ in truth]


@pytest.mark.parametrize("begin", [1e9, 1e15, 1.7e18, -1e300])
def test_times_that_are_too_large_for_fractions_hang_nothing(moves, take, begin):
    positions, times, _ = take
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    for at in range(0, 300, 10):
        segmenter.push(positions[at : at + 10], begin + times[at : at + 10])
    segmenter.end_take()


@pytest.mark.parametrize("scale", [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("begin", [0.0, 1.7e9])
@pytest.mark.filterwarnings("ignore:performer p1. each frame is a take of its own")
def test_times_in_other_units_make_snapshots_that_are_restored(moves, take, begin, scale):
    positions, times = take[0][:200], (begin + take[1][:200]) * scale
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    expected = [*segmenter.push(positions, times), *segmenter.end_take()]
    segmenter, events = Segmenter(PERSON, moves=moves, follow=True), []
    for frame, time in zip(positions, times, strict=True):
        events += segmenter.push(frame, time)
        segmenter = Segmenter.restore(segmenter.snapshot())
    assert [*events, *segmenter.end_take()] == expected


def test_who_stands_or_trembles_makes_no_move(moves):
    rng = np.random.default_rng(6)
    still = np.repeat(STANDING[None], 900, axis=0) + rng.normal(0, 0.004, (900, 15, 3))
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    assert not followed(events_of(segmenter, still.astype(np.float32), np.arange(900) / FPS, 64), "done")


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    size=st.sampled_from([1, 3, 16]),
    cut=st.integers(1, 80),
    fps=st.sampled_from([7.0, 15.0, 24.0, 30.0, 61.0]),
)
def test_any_stream_gives_sound_events_however_it_is_cut(moves, seed, size, cut, fps):
    rng = np.random.default_rng(seed)
    count = 90
    frames = STANDING + np.cumsum(rng.normal(0, 0.03, (count, 15, 3)), axis=0)
    frames[rng.random((count, 15)) < 0.1] = np.nan
    frames[rng.random(count) < 0.02] = 1e7
    times = np.cumsum(rng.exponential(1 / fps, count))
    times[rng.random(count) < 0.03] -= 0.2
    times[rng.random(count) < 0.02] = np.nan
    frames = frames.astype(np.float32)
    whole = events_of(Segmenter(PERSON, moves=moves, follow=True), frames, times, count)
    assert lines_of(events_of(Segmenter(PERSON, moves=moves, follow=True), frames, times, size)) == lines_of(
        whole
    )
    first = Segmenter(PERSON, moves=moves, follow=True)
    events = first.push(frames[:cut], times[:cut])
    second = Segmenter.restore(first.snapshot())
    events += [*second.push(frames[cut:], times[cut:]), *second.end_take()]
    assert lines_of(events) == lines_of(whole)
    last = {}
    for event in followed(whole):
        assert event.status != "begun" or event.id not in last
        assert last.get(event.id) not in ("done", "left")
        assert 0 <= event.progress <= 1
        assert 0 <= event.certainty <= 1
        assert np.isfinite(
            [event.deviation, event.tempo, event.start, event.time, *event.limbs.values()]
        ).all()
        last[event.id] = event.status
    assert set(last.values()) <= {"done", "left"}


def test_a_snapshot_of_other_moves_counts_on(moves, take):
    positions, times, truth = take
    end = truth[1][2] + 10
    first = Segmenter(PERSON, moves=moves, follow=True)
    before = followed(first.push(positions[:end], times[:end]))
    fewer = moves.copy()
    fewer.remove("circle_left")
    second = Segmenter.restore(first.snapshot(with_moves=False), fewer)
    after = followed([*second.push(positions[end:], times[end:]), *second.end_take()])
    assert {event.id for event in after}.isdisjoint(event.id for event in before)


def test_bytes_changed_at_random_are_refused_or_harmless(moves, take):
    positions, times, _ = take
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    segmenter.push(positions[:110], times[:110])
    good = segmenter._followers.alignment.to_bytes()
    rng = np.random.default_rng(8)
    for _ in range(40):
        bad = np.frombuffer(good, np.uint8).copy()
        bad[rng.integers(0, 1500, 4)] = rng.integers(0, 256, 4)
        fresh = Segmenter(PERSON, moves=moves, follow=True)
        try:
            fresh._followers.alignment.go_on_from(bad.tobytes())
        except SnapshotError:
            continue
        events = [*fresh.push(positions[110:], times[110:]), *fresh.end_take()]
        assert all(isinstance(event.progress, float) for event in events if isinstance(event, FollowEvent))


def test_memory_has_a_fixed_size(moves, take):
    positions, times, _ = take
    segmenter = Segmenter(PERSON, moves=moves, follow=True)
    before = segmenter.state_bytes
    segmenter.push(positions, times)
    assert segmenter.state_bytes == before
    assert before - Segmenter(PERSON, moves=moves).state_bytes < 200_000 * len(ORDER)


def test_ctrl_c_anywhere_loses_no_performance_and_no_revision(moves, take):
    positions, times, truth = take
    whole = Segmenter(PERSON, moves=moves, follow=True)
    told = [
        k for k in range(150) if followed(whole.push(positions[k], float(times[k])), "done", "left", "begun")
    ]
    for k in told[:3]:
        fresh = Segmenter(PERSON, moves=moves, follow=True)
        begin, blob = fresh.push(positions[:k], times[:k]), fresh.snapshot()
        for after in range(1, 1000):
            segmenter, events, strike = Segmenter.restore(blob), list(begin), Striking(after)
            with strike:
                events += segmenter.push(positions[k], float(times[k]))
            if not strike.has_struck:
                break
            events += [*segmenter.push(positions[k + 1 :], times[k + 1 :]), *segmenter.end_take()]
            revisions = {}
            for event in followed(events):
                assert event.rev == revisions.get(event.id, 0) + 1
                revisions[event.id] = event.rev
            assert [e.name for e in followed(events, "done")] == [name for name, _, _ in truth]
        assert after > 1


DAMAGE = {
    "phase": [-1, 10**6],
    "layer": [-1, 2],
    "best_layer": [-1, 2],
    "example": [-1, 10**6],
    "best_example": [-1, 10**6],
    "first": [-(2**62)],
    "last": [2**62],
    "best_first": [-(2**62)],
    "best_last": [2**62],
    "active": [2],
    "recents": [-1],
    "start": [np.nan],
    "progress": [np.nan, 1e4],
}


@pytest.fixture(scope="module")
def halfway(moves, take):
    """A segmenter in the middle of a performance."""
    positions, times, truth = take
    own = Segmenter(PERSON, moves=moves, follow=True)
    own.push(positions[: truth[1][2]], times[: truth[1][2]])
    return own


def changed(alignment, change):
    """Return what is known of a performer after a change of its memory."""
    memory = alignment.state.copy()
    change(memory)
    return memory.tobytes()


@pytest.mark.parametrize("name", DAMAGE)
def test_a_way_that_leads_out_of_the_cells_is_refused(halfway, name):
    alignment = halfway._followers.alignment
    for value in DAMAGE[name]:

        def change(memory, value=value):
            parts_of(memory, follow_memory_parts(alignment.store))["moves"][name][0] = value

        with pytest.raises(SnapshotError, match="contradicts itself"):
            alignment.go_on_from(changed(alignment, change))
    alignment.go_on_from(alignment.to_bytes())


@pytest.mark.parametrize(("value", "column"), [(4, 5), (1, 1), (1, 0), (255, 2)])
def test_a_step_beyond_the_first_phase_is_refused(halfway, value, column):
    """The trace of a way would leave the memory: that was a segmentation fault."""
    alignment = halfway._followers.alignment

    def change(memory):
        parts_of(memory, follow_cell_parts(alignment.store, 0))["steps"][0, column] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        alignment.go_on_from(changed(alignment, change))


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_directions_that_are_none_are_refused(halfway, value):
    alignment = halfway._followers.alignment

    def change(memory):
        parts_of(memory, follow_memory_parts(alignment.store))["boxes"].flat[0] = value

    with pytest.raises(SnapshotError, match="contradicts itself"):
        alignment.go_on_from(changed(alignment, change))


@pytest.mark.parametrize("begin", [-1e30, np.nan, 1e30])
def test_a_sample_that_is_never_due_or_always_is_refused(halfway, begin):
    alignment = halfway._followers.alignment

    def change(memory):
        parts_of(memory, follow_memory_parts(alignment.store))["state"]["begin"] = begin

    with pytest.raises(SnapshotError, match="contradicts itself"):
        alignment.go_on_from(changed(alignment, change))
