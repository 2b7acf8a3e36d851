"""The bounded window over a live stream: the life of key frames and segments, levels, and what is decided when."""

import itertools
from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st

from mossar_stream import Segmenter, Settings, segment_recording
from mossar_stream.core.row import region

# Status: what may follow it.
NEXT = {
    None: {"candidate", "confirmed"},
    "candidate": {"withdrawn", "confirmed"},
    "confirmed": {"merged", "final", "withdrawn"},  # withdrawn at the end of the take only
    "merged": {"restored", "merged", "withdrawn"},
    "restored": {"merged", "final", "withdrawn"},
    "withdrawn": set(),
    "final": set(),
}
SEGMENT_NEXT = {
    None: {"closed", "final"},
    "closed": {"withdrawn", "final"},
    "withdrawn": {"closed", "final"},  # final if a key frame in the last frame was merged
    "final": set(),
}
OF_EVERY_SIMILARITY = {
    "remerge_window": st.sampled_from([1, 2, 3, 8, 40]),
    "remerge_seconds": st.sampled_from([0.05, 0.3, 1.0, 1e6]),
    "refine": st.sampled_from([0.0, 0.1, 1.0]),
    "range_floor": st.just(0.01),
    "sig_threshold": st.sampled_from([0.01, 0.05]),
    "window": st.sampled_from([0.03, 0.1]),
    "rate_limit": st.just(0.0),
    "noise_margin": st.just(0.0),
}
OF_THE_LIKELIHOOD = {
    "similarity": st.just("likelihood"),
    "level": st.sampled_from(["posture", "motion", "cluster", 0.01, 0.05, 0.2]),
    "location": st.sampled_from(["none", "free", "candidates"]),
    "pre_roll": st.sampled_from([0.0, 0.5]),
    "post_roll": st.sampled_from([0.0, 0.5]),
    "tempo": st.booleans(),
}
OF_EVIDENCE = {"level": st.sampled_from(["motion", 0.05, 0.2])}
LIVES = st.one_of(
    st.fixed_dictionaries({**OF_EVERY_SIMILARITY, **OF_THE_LIKELIHOOD}),
    st.fixed_dictionaries({**OF_EVERY_SIMILARITY, **OF_EVIDENCE}),
)


class Witness:
    """Follows the messages of one take and objects to whatever must not happen."""

    def __init__(self, *, delayed):
        self.ended, self.delayed = False, delayed
        self.keys, self.segments = {}, {}
        self.revs = defaultdict(int)
        self.finals, self.final_segments, self.standing = [], [], set()

    def see(self, event):
        self.revs[event.id] += 1
        assert event.rev == self.revs[event.id]
        return (self.see_key_frame if event.__struct_config__.tag == "key_frame" else self.see_segment)(event)

    def see_key_frame(self, event):
        before = self.keys.get(event.id)
        assert before is None or not before.decided
        assert event.status in NEXT[before.status if before else None]
        if event.status == "withdrawn" and before.status != "candidate":
            assert self.ended
        if event.status == "merged" and before.status == "merged":
            assert event.decided
        if before is None and event.status == "confirmed":
            assert event.kind in ("onset", "offset")
        assert event.decided == (
            event.status in ("withdrawn", "final") or (event.decided and event.status == "merged")
        )
        assert event.strength is None or 0 <= event.strength < np.inf
        assert np.isfinite([event.velocity, event.time, event.decided_time]).all()
        if event.status != "final":
            # At level motion a key frame is told to be where it was before smoothing and velocity delayed it.
            assert 0 <= int(event.id.rsplit("/", 1)[1]) - event.frame <= (5 if self.delayed else 0)
        else:
            assert not self.finals or self.finals[-1].frame < event.frame
            self.finals.append(event)
        self.keys[event.id] = event
        if event.status in ("confirmed", "restored"):
            self.standing.add(event.id)
        elif event.status in ("merged", "withdrawn"):
            self.standing.discard(event.id)

    def see_segment(self, event):
        before = self.segments.get(event.id)
        assert event.status in SEGMENT_NEXT[before.status if before else None]
        assert event.similarity is None or 0 <= event.similarity <= 1
        assert len(event.active_joints) <= 5
        assert event.end_frame >= event.start_frame
        self.segments[event.id] = event
        if event.status == "final":
            self.final_segments.append(event)

    def closed_segments_follow_the_standing_key_frames(self, start):
        numbers = sorted(int(i.rsplit("/", 1)[1]) for i in self.standing)
        ends = [start, *numbers]
        expected = {f"{a}-{b}" for a, b in itertools.pairwise(ends)}
        found = {i.rsplit("/", 1)[1] for i, e in self.segments.items() if e.status != "withdrawn"}
        assert found == expected

    def end(self, first_frame, last_frame):
        assert all(e.decided for e in self.keys.values())
        assert all(e.status in ("final", "withdrawn") for e in self.segments.values())
        assert self.standing == {e.id for e in self.finals}
        bounds = [first_frame, *(e.frame for e in self.finals), last_frame]
        assert [(e.start_frame, e.end_frame) for e in self.final_segments] == list(itertools.pairwise(bounds))
        assert self.final_segments[0].similarity is None
        assert all(e.similarity is not None for e in self.final_segments[1:])


def witnessed(core, seed, life, levels=(), frames=300):
    """Run a stream frame by frame with levels moved now and then, and return its witness."""
    positions, times = core.moving_people(seed, frames=frames, losses=False)
    segmenter = Segmenter(core.skeleton(4), Settings(**life))
    witness = Witness(delayed=segmenter.settings.resolved().similarity == "evidence")
    for t in range(frames):
        for at, level in levels:
            if at == t:
                segmenter.level = level
        for event in segmenter.push(positions[t], times[t]):
            if event.__struct_config__.tag not in ("stream", "activity"):
                assert event.__struct_config__.tag == "segment" or event.decided_frame <= t
                witness.see(event)
        witness.closed_segments_follow_the_standing_key_frames(0)
    witness.ended = True
    for event in segmenter.end_take():
        if event.__struct_config__.tag not in ("stream", "activity"):
            witness.see(event)
    witness.end(0, frames - 1)
    return witness


@given(
    st.integers(0, 10**6),
    LIVES,
    st.lists(
        st.tuples(st.integers(0, 299), st.sampled_from([0.0, 0.03, 0.1, 1.25, 1e8])),
        max_size=6,
    ),
)
def test_key_frames_and_segments_live_as_the_schema_says(core, seed, life, levels):
    witnessed(core, seed, life, levels)


@pytest.mark.parametrize("seed", range(3))
def test_a_refined_final_lies_strictly_between_its_neighbours(core, seed):
    life = {
        "similarity": "likelihood",
        "location": "free",
        "refine": 0.3,
        "level": 0.02,
        "range_floor": 0.01,
        "window": 0.05,
        "rate_limit": 0.0,
    }
    witness = witnessed(core, seed, life)
    moved = [e for e in witness.finals if e.frame != int(e.id.rsplit("/", 1)[1])]
    assert moved
    bounds = [0, *(e.frame for e in witness.finals), 299]
    assert all(a < b for a, b in itertools.pairwise(bounds[:-1]))
    assert all(abs(e.time - int(e.id.rsplit("/", 1)[1]) / 60) <= 0.3 + 0.05 for e in moved)


def key_frames_of(core, positions, times, settings):
    segmenter = Segmenter(core.skeleton(positions.shape[1]), settings)
    events = segmenter.push(positions, times) + segmenter.end_take()
    decided = [
        e for e in events if e.__struct_config__.tag == "key_frame" and e.decided and e.status != "withdrawn"
    ]
    return sorted(decided, key=lambda e: e.frame)


@pytest.mark.parametrize("level", ["posture", "motion", "cluster", 0.05])
@pytest.mark.parametrize("seed", range(3))
def test_a_window_as_long_as_the_take_gives_the_offline_result(core, seed, level):
    settings = Settings(
        level=level, remerge_window=400, remerge_seconds=1e9, location="none", range_floor=0.01, window=0.05
    )
    positions, times = core.moving_people(seed, frames=700, losses=False)
    offline = segment_recording(positions, times=times, skeleton=core.skeleton(4), settings=settings)
    online = key_frames_of(core, positions, times, settings)
    assert len(online) > 20
    told = {e.frame for e in online}  # evidence works with more key frames than a stream tells of
    among = [k for k in offline.key_frames if k.frame in told]
    assert [(e.frame, e.kind) for e in online] == [(k.frame, k.kind) for k in among]
    np.testing.assert_allclose([e.strength for e in online], [k.strength for k in among], rtol=0, atol=1e-9)
    standing = offline.at(level)
    assert [e.frame for e in online if e.status == "final"] == [k.frame for k in standing.key_frames]


def test_the_oldest_is_decided_when_more_than_w_are_undecided(core):
    positions, times = core.moving_people(1, frames=900, losses=False)
    segmenter = Segmenter(
        core.skeleton(4), Settings(remerge_window=3, remerge_seconds=1e9, range_floor=0.01, window=0.05)
    )
    undecided = set()
    for t in range(900):
        for e in segmenter.push(positions[t], times[t]):
            if e.__struct_config__.tag == "key_frame" and e.status != "candidate":
                (undecided.discard if e.decided else undecided.add)(e.id)
        assert len(undecided) <= 3


def test_the_oldest_is_decided_by_frame_time_even_if_nothing_else_happens(core):
    curve = np.r_[np.zeros(9), np.full(9, 8), np.zeros(200)] / 16
    settings = {"remerge_seconds": 1.5, "level": "posture"}
    events = core.segmenter_of(settings, 1 / 16).push(core.hand_steps(curve))
    for e in core.key_frames(events, "final"):
        assert e.decided_time == pytest.approx(e.time + 1.5, abs=1 / core.FPS)
    assert len(core.key_frames(events, "final")) == 2


def test_the_oldest_is_ranked_again_only_where_its_strength_is_near_the_level(core):
    level = 0.05
    settings = Settings(level="posture", remerge_seconds=0.5, location="none", range_floor=0.01, window=0.05)
    clear, near, changed = 0, 0, 0
    for seed in range(6):
        positions, times = core.moving_people(seed, frames=900, losses=False)
        segmenter = Segmenter(core.skeleton(4), settings)
        segmenter.level = level
        key, h = (
            region(segmenter.row.memory, "keys"),
            segmenter.row.state["window"],
        )
        for t in range(900):
            ranked = h["ranked"] == 1 and h["undecided"] > 0
            identity, strength, stood = key["frame"][0], key["strength"][0], key["kept"][0]
            told = [
                e for e in segmenter.push(positions[t], times[t]) if e.__struct_config__.tag == "key_frame"
            ]
            decided = [e for e in told if e.decided and e.status != "withdrawn"]
            if not ranked or not decided or any(e.status == "confirmed" for e in told):
                continue  # a new key frame has the window ranked in any case
            assert decided[0].id == f"p1/0/{identity}"
            if strength >= 2 * level or strength <= level / 2:
                clear += 1
                assert decided[0].strength == strength
                assert decided[0].status == ("final" if stood else "merged")
            else:
                near += 1
                changed += decided[0].strength != strength
                assert decided[0].status == ("final" if decided[0].strength >= level else "merged")
    assert min(clear, near, changed) > 5


def test_the_row_does_not_grow_with_the_stream(core):
    positions, times = core.moving_people(2, frames=1200, losses=False)
    segmenter = Segmenter(core.skeleton(4), Settings(range_floor=0.01, window=0.05))
    for turn in range(40):
        segmenter.push(positions, times + turn * (times[-1] + 1.0))
        if turn == 10:
            size = len(segmenter.snapshot())
    assert len(segmenter.snapshot()) < size + 200


def test_a_level_acts_at_once_and_comes_back_with_the_next_push(core):
    positions, times = core.moving_people(3, frames=240, losses=False)
    settings = Settings(
        similarity="likelihood",
        level=0.0,
        remerge_seconds=1e6,
        remerge_window=50,
        range_floor=0.01,
        window=0.05,
    )
    segmenter = Segmenter(core.skeleton(4), settings)
    segmenter.push(positions[:200], times[:200])
    segmenter.level = 1e6
    events = segmenter.push(positions[200], times[200])
    segmenter.level = 0.0
    events += segmenter.push(positions[201], times[201])
    told = [e.status for e in events if e.__struct_config__.tag == "key_frame"]
    assert told.count("merged") == told.count("restored") > 5
    segmenter.level = 1e6
    assert {e.status for e in core.key_frames(segmenter.end_take(), "merged")} == {"merged"}


@examples(max_examples=30)
@given(st.integers(0, 10**6), st.lists(st.floats(0, 3), min_size=2, max_size=5))
def test_nobody_is_overwhelmed_by_many_decisions_at_once(core, seed, pauses):
    rng = np.random.default_rng(seed)
    settings = Settings(
        remerge_window=40, remerge_seconds=0.9, max_pause=5.0, level=0.02, range_floor=0.001,
        sig_threshold=0.02, window=0.02, location="candidates", refine=1.0, similarity="likelihood", rate_limit=0.0,
    )  # fmt: skip
    segmenter = Segmenter(core.skeleton(3), settings)
    witness, time, number = Witness(delayed=True), 0.0, 0
    for pause in pauses:
        for _ in range(60):
            time += 0.01
            number += 1
            for e in segmenter.push(rng.normal(0, 0.02, (3, 3)).astype(np.float32), time):
                if e.__struct_config__.tag != "stream":
                    witness.see(e)
        time += pause
    witness.ended = True
    for e in segmenter.end_take():
        if e.__struct_config__.tag != "stream":
            witness.see(e)
    witness.end(0, number - 1)
