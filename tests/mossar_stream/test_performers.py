"""Many performers: each is as if alone."""

import copy
import gc
import pickle
import random
import weakref
from collections import Counter

import numpy as np
import pytest

from checks.interrupts.alone import Tally
from checks.interrupts.pools import live_in_pool
from checks.interrupts.striking import Striking
from checks.random_takes import moves_of
from mossar_adapters.demo import SKELETON, performance
from mossar_stream import (
    FrameError,
    Frames,
    Performers,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    SnapshotError,
)

SETTINGS = Settings(range_floor=0.01, window=0.05)


def pushed(pool, core, name, seed, part=slice(None)):
    positions, times = core.moving_people(seed)
    return pool.push(Frames(positions[part], times[part], performer=name))


def test_ten_performers_interleaved_are_ten_runs(core):
    pool, alone, together = Performers(SETTINGS), {}, {}
    for number in range(10):
        name = f"p{number}"
        pool.announce(name, core.skeleton(4))
        single = Segmenter(core.skeleton(4), SETTINGS, name)
        alone[name] = core.lines(single.push(*core.moving_people(number)) + single.end_take())
        together[name] = []
    for at in range(0, 240, 6):
        for number in np.random.default_rng(at).permutation(10):
            events = pushed(pool, core, f"p{number}", number, slice(at, at + 6))
            together[f"p{number}"] += core.lines(events)
    for event in pool.end_takes():
        together[event.performer] += core.lines([event])
    assert together == alone


def test_a_performer_who_was_not_announced_is_refused(core):
    with pytest.raises(FrameError, match="'bob' was not announced"):
        pushed(Performers(), core, "bob", 0)


def test_the_name_is_made_fit_on_both_ways_in(core):
    pool = Performers()
    pool.announce("a.b", core.skeleton(4))
    assert pushed(pool, core, "a.b", 0)[0].performer == "a_b"
    assert pool.names == ("a_b",)


def test_another_skeleton_ends_the_take_and_the_same_one_does_not(core):
    pool = Performers()
    assert pool.announce("ann", core.skeleton(4)) == []
    pushed(pool, core, "ann", 0, slice(0, 50))
    assert pool.announce("ann", core.skeleton(4)) == []
    events = pool.announce("ann", Skeleton(("a", "b")))
    assert (events[-1].event, events[-1].reason) == ("ended", "another skeleton")
    assert len(pool["ann"].skeleton) == 2
    with pytest.raises(FrameError):
        pushed(pool, core, "ann", 0)


def test_the_one_idle_for_longest_makes_room(core):
    pool = Performers(SETTINGS, most=2)
    for name in ("ann", "bob"):
        pool.announce(name, core.skeleton(4))
        pushed(pool, core, name, 0, slice(0, 50))
    pushed(pool, core, "ann", 0, slice(50, 60))
    events = pool.announce("eve", core.skeleton(4))
    assert pool.names == ("ann", "eve")
    assert (events[-1].performer, events[-1].reason) == ("bob", "too many performers")
    assert "bob" not in pool
    assert len(pool) == 2


def test_who_had_to_make_room_goes_on_with_the_next_take_and_its_own_settings(core):
    pool = Performers(SETTINGS, most=2)
    for name in ("ann", "bob"):
        pool.announce(name, core.skeleton(4))
        pushed(pool, core, name, 0, slice(0, 50))
    pool.change("ann", sig_threshold=0.4)
    pool.announce("ann", Skeleton(("a", "b")))
    assert pool["ann"].settings.sig_threshold == 0.4, "also with another skeleton"
    pool.announce("eve", core.skeleton(4))
    pool.announce("bob", core.skeleton(4))
    started, *_ = pushed(pool, core, "bob", 0, slice(100, 150))
    assert (started.performer, started.take) == ("bob", 1)
    assert pool["bob"].stats["frames"] == 100
    assert pool["bob"].settings == pool.settings
    pool.announce("ann", core.skeleton(4))
    assert pool["ann"].settings == pool.settings.replace(sig_threshold=0.4)


def test_ids_stay_unique_when_those_who_made_room_are_forgotten(core, monkeypatch):
    monkeypatch.setattr("mossar_stream.performers.MOST_ABSENT", 2)
    pool = Performers(SETTINGS, most=1)
    names = ["ann", "bob", "ann", "eve", "joe", "sue", "ann", "bob"]
    takes = []
    for name in names:
        pool.announce(name, core.skeleton(4))
        started, *_ = pushed(pool, core, name, 0, slice(0, 50))
        takes.append((name, started.take))
    assert len(set(takes)) == len(names), takes
    assert [take for name, take in takes if name == "ann"][1] == 1


def test_a_pool_that_goes_on_knows_its_settings_and_who_made_room(core):
    pool = Performers(SETTINGS, most=2)
    for name in ("ann", "bob"):
        pool.announce(name, core.skeleton(4))
        pushed(pool, core, name, 0, slice(0, 50))
    pool.change(sig_threshold=0.3)
    pool.change("ann", window=0.4)
    pool.level = 0.7
    pool.announce("eve", core.skeleton(4))  # in place of ann
    again = Performers(SETTINGS, most=2)
    again.restore(pool.snapshot(), pool.lasting())
    assert again.settings == pool.settings != SETTINGS
    assert again.names == pool.names
    again.announce("ann", core.skeleton(4))
    assert again["ann"].settings == pool.settings.replace(window=0.4)
    assert again["ann"].take == 1
    again.announce("joe", core.skeleton(4))
    assert again["joe"].settings == pool.settings
    with pytest.raises(SnapshotError, match="settings cannot be read"):
        again.restore({}, b"\x00damaged")
    assert again.names == ("ann", "joe")


def test_at_least_one_performer_is_followed():
    with pytest.raises(ValueError, match="at least one performer"):
        Performers(most=0)


def test_a_level_holds_for_all_and_for_those_to_come_but_the_bundle_stays(core):
    pool = Performers(Settings(level="cluster"))
    pool.announce("ann", core.skeleton(4))
    pool.level = 0.7
    pool.announce("bob", core.skeleton(4))
    assert [pool[name].level for name in pool.names] == [0.7, 0.7]
    assert pool.level == pool.settings.level == 0.7
    resolved = [pool[name].row.plan.settings for name in pool.names]
    assert resolved[0] == resolved[1] == Settings(level="cluster").resolved()
    pool.change(level="motion")
    pool.announce("eve", core.skeleton(4))
    assert {pool[name].level for name in pool.names} == {"motion"}
    assert {pool[name].row.state["plan"]["beta"].item() for name in pool.names} == {
        pool["ann"].row.state["plan"]["beta"].item()
    }


def test_settings_change_for_all_and_for_those_to_come(core):
    pool = Performers()
    pool.announce("ann", core.skeleton(4))
    pushed(pool, core, "ann", 0, slice(0, 50))
    assert pool.change(window=0.5)[-1].event == "ended"
    pool.announce("bob", core.skeleton(4))
    assert [pool[name].settings.window for name in pool.names] == [0.5, 0.5]
    assert pool.change("bob", window=0.3) == []
    assert [pool[name].settings.window for name in pool.names] == [0.5, 0.3]
    for wrong in ({"window": -1}, {"level": "loud"}, {"widow": 1}):
        with pytest.raises(SettingsError):
            pool.change(**wrong)
    assert [pool[name].settings.window for name in pool.names] == [0.5, 0.3]
    with pytest.raises(FrameError, match="no performer called 'eve'"):
        pool.change("eve", window=0.3)


def test_a_performer_is_reset_or_removed_alone(core):
    pool = Performers(SETTINGS)
    for name in ("ann", "bob"):
        pool.announce(name, core.skeleton(4))
        pushed(pool, core, name, 0, slice(0, 100))
    assert [e.event for e in pool.reset("ann") if hasattr(e, "event")] == ["ended", "reset"]
    assert {e.performer for e in pool.remove("bob", "gone")} == {"bob"}
    assert pool.names == ("ann",)
    with pytest.raises(FrameError):
        pool.reset("bob")


# Many at once.


def crowd(core, count, joints=4, frames=240, **settings):
    """Return a pool of people who move at random, their positions (P, n, J, 3) and times."""
    pool = Performers(Settings(range_floor=0.01, **settings))
    for seed in range(count):
        pool.announce(f"p{seed}", core.skeleton(joints), fps=60.0)
    positions = np.stack([core.moving_people(s, frames, joints, losses=False)[0] for s in range(count)])
    return pool, positions, np.arange(frames) / 60.0


def lines_by_performer(core, events):
    found = {}
    for event in events:
        found.setdefault(event.performer, []).extend(core.lines([event]))
    return found


def alone(core, pool, positions, times):
    """Return the events of each performer followed by itself."""
    found = {}
    for name, own in zip(pool.names, positions, strict=True):
        segmenter = Segmenter(core.skeleton(own.shape[1]), pool.settings, name, fps=60.0)
        found[name] = core.lines(segmenter.push(own, times) + segmenter.end_take())
    return found


@pytest.mark.parametrize("chunk", [1, 7, 240])
def test_many_at_once_have_the_events_of_each_alone(core, chunk):
    pool, positions, times = crowd(core, 70)  # more than a page
    expected = alone(core, pool, positions, times)
    events = []
    for begin in range(0, 240, chunk):
        part = slice(begin, begin + chunk)
        events += pool.push_many(pool.names, positions[:, part], times[part])
    assert lines_by_performer(core, events + pool.end_takes()) == expected
    assert sum(map(len, expected.values())) > 1000


def test_in_a_crowd_takes_end_and_rings_grow_for_one_alone(core):
    pool, positions, times = crowd(core, 5)
    own = np.tile(times, (5, 1))
    own[1, 100:] += 5.0  # a gap
    own[2] /= 20.0  # 1200 Hz where 60 Hz were announced
    expected = {}
    for k, name in enumerate(pool.names):
        segmenter = Segmenter(core.skeleton(4), pool.settings, name, fps=60.0)
        expected[name] = core.lines(segmenter.push(positions[k], own[k]) + segmenter.end_take())
    events = pool.push_many(pool.names, positions[:, :150], own[:, :150])
    events += pool.push_many(pool.names, positions[:, 150:], own[:, 150:])
    assert lines_by_performer(core, events + pool.end_takes()) == expected


@pytest.mark.parametrize("people", [1, 3])
@pytest.mark.parametrize("own", [False, True])
def test_times_may_be_everybody_s_or_each_one_s_and_need_not_be_writeable(core, people, own):
    pool, positions, times = crowd(core, people)
    expected = alone(core, pool, positions, times)
    given = np.tile(times, (people, 1)) if own else times.copy()
    for array in (given, positions):
        array.flags.writeable = False
    events = pool.push_many(pool.names, positions, given)
    assert lines_by_performer(core, events + pool.end_takes()) == expected


def test_a_crowd_goes_on_when_settings_change_and_people_come_and_go(core):
    pool, positions, times = crowd(core, 6)
    first = pool.push_many(pool.names, positions[:, :100], times[:100])
    assert {e.performer for e in first} == set(pool.names)
    pool.change("p1", window=0.3)  # p1 leaves its page
    pool.level = 0.01
    pool.remove("p2")
    pool.announce("p9", core.skeleton(4), fps=60.0)
    names = [name for name in pool.names if name != "p9"]
    later = pool.push_many([*names, "p9"], positions[:, 100:], times[100:])
    assert {e.performer for e in later if e.__struct_config__.tag == "stream"} == {"p1", "p9"}
    one = Segmenter(core.skeleton(4), Settings(range_floor=0.01, level=0.01), "p9", fps=60.0)
    own = [e for e in later + pool.end_takes() if e.performer == "p9"]
    expected = one.push(positions[5, 100:], times[100:]) + one.end_take()
    assert [(e.id, e.status) for e in core.key_frames(own, "final")] == [
        (e.id, e.status) for e in core.key_frames(expected, "final")
    ]


@pytest.mark.parametrize(
    ("names", "shape", "times", "message"),
    [
        (("p0", "nobody"), (2, 3, 4, 3), 3, "performer 'nobody' was not announced"),
        (("p0", "p0"), (2, 3, 4, 3), 3, "a performer is named twice"),
        (("p0", "p1"), (3, 3, 4, 3), 3, "2 performers need"),
        (("p0", "p1"), (2, 3, 5, 3), 3, "positions have 5 joints; performer 'p0' has 4"),
        (("p0", "p1"), (2, 3, 4, 3), 4, "but times"),
    ],
)
def test_a_crowd_that_does_not_fit_is_refused_before_anything_is_taken_in(core, names, shape, times, message):
    pool, _, _ = crowd(core, 2, frames=8)
    with pytest.raises(FrameError, match=message):
        pool.push_many(names, np.zeros(shape, np.float32), np.arange(times))
    assert [pool[name].stats["frames"] for name in pool.names] == [0, 0]


@pytest.mark.parametrize("kind", [{}, {"limbs": True}, {"repetitions": True}])
def test_who_left_takes_no_memory_until_the_collector_comes_by(kind):
    performers = Performers(Settings(**kind), most=2)
    skeleton = Skeleton(("hip", "left_hand", "right_hand"), (-1, 0, 0))

    def came_and_left(name):
        performers.announce(name, skeleton, 60.0)
        performers.push(Frames(np.ones((2, 3, 3), np.float32), np.arange(2) / 60, None, name))
        gone = weakref.ref(performers[name])
        performers.remove(name)
        return gone

    came_and_left("bob")  # the first performer, before garbage collection stops
    gc.disable()
    try:
        assert came_and_left("ann")() is None
    finally:
        gc.enable()


def known_of(pool):
    """Everything that a pool knows, as bytes."""
    return pool.names, pool.lasting(), pool.snapshot(), pool.moves


def random_request(rng, core):
    """Something that may be asked of a pool, right or wrong: a method and its arguments."""
    names = ("ann", "bob", "cy", "dee")
    changes = (
        {"limbs": "arm=j1"},
        {"limbs": "arm=other"},
        {"limbs": False},
        {"steps": True},
        {"steps": True, "feet": "left=j1 right=j2"},
        {"feet": "left=j1 right=other"},
        {"phase": True},
        {"repetitions": True},
        {"repetitions": False},
        {"window": 0.1},
        {"window": 99.0},
        {"level": "cluster"},
        {"level": "motion", "features": {"positions": 1.0}},
        {"level": "cluster", "features": {"positions": 1.0}},
        {"level": 0.3},
        {"similarity": "path_kernel"},
        {"location": "free"},
        {"nothing": 1},
    )
    skeletons = (core.skeleton(4), core.skeleton(3), Skeleton(("other", "one"), (-1, 0)), core.skeleton(4))
    return rng.choice(
        (
            lambda pool: pool.announce(rng.choice(names), rng.choice(skeletons)),
            lambda pool: pool.change(**rng.choice(changes)),
            lambda pool: pool.change(rng.choice(names), **rng.choice(changes)),
            lambda pool: setattr(pool, "level", rng.choice(("motion", "cluster", "nothing", 0.2, -1, "x"))),
            lambda pool: pool.reset(rng.choice((*names, None))),
            lambda pool: pool.remove(rng.choice(names)),
            lambda pool: pool.push(Frames(*core.moving_people(1), performer=rng.choice(names))),
        )
    )


def test_what_is_refused_changes_nothing(core):
    rng, refused, done = random.Random(4), 0, 0
    for _ in range(12):
        pool = Performers(SETTINGS, most=3, most_memory=3_000_000)
        for _ in range(40):
            request = random_request(rng, core)
            before = known_of(pool)
            try:
                request(pool)
                done += 1
            except (FrameError, SettingsError, KeyError):
                refused += 1
                assert known_of(pool) == before
    assert refused > 100
    assert done > 100


def test_a_pool_in_use_refuses_before_anything_is_changed(core):
    pool = Performers(SETTINGS, most=2)
    for name in ("ann", "bob"):
        pool.announce(name, core.skeleton(4))
        pushed(pool, core, name, 1)
    before = known_of(pool)
    guard = pool["bob"].core.workspace
    for request in (
        lambda: pool.change(window=0.1),
        lambda: setattr(pool, "level", 0.1),
        lambda: setattr(pool, "moves", None),
        pool.reset,
        pool.end_takes,
        lambda: pool.remove("bob"),
        lambda: pool.announce("bob", core.skeleton(3)),
    ):
        guard.is_busy = True
        with pytest.raises(RuntimeError, match="two threads"):
            request()
        guard.is_busy = False
        assert known_of(pool) == before


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda pool: pickle.loads(pickle.dumps(pool))])
def test_a_copy_of_a_pool_goes_on_by_itself(core, way):
    pool = Performers(SETTINGS, most=3, moves=moves_of(1), follow=True)
    for name in ("ann", "bob", "eve"):
        pool.announce(name, SKELETON)
        pool.push(
            Frames(performance(fps=30.0, seconds=2.0).frames.positions, np.arange(60) / 30, performer=name)
        )
    pool.change("bob", window=0.2)
    pool.announce("dan", SKELETON)  # ann makes room
    other = way(pool)
    assert known_of(other)[:2] == known_of(pool)[:2]
    assert (other.moves.names, other.follow) == (pool.moves.names, True)
    events = [one.announce("ann", SKELETON) + one.end_takes() for one in (other, pool)]
    assert core.lines(events[0]) == core.lines(events[1])
    assert other["ann"].take == pool["ann"].take == 1
    other.push(Frames(np.zeros((1, len(SKELETON), 3)), np.zeros(1), performer="dan"))
    assert pool["dan"].stats["frames"] == 0


def test_ctrl_c_in_a_pool_loses_no_event_and_repeats_none():
    tally = Tally(Counter(), Counter(), [])
    for seed in (5, 11, 15, 17):
        live_in_pool(seed, tally, compared=0.1)
    assert not tally.wrong
    assert sum(tally.struck.values()) > 20


PLACES = (*range(1, 40, 3), *(int(40 * 1.3**k) for k in range(30)))  # of Ctrl-C
WAYS = {
    "end_takes": lambda pool: pool.end_takes(),
    "reset": lambda pool: pool.reset(),
    "announce": lambda pool: pool.announce("eve", Skeleton(("a", "b"))),
    "remove": lambda pool: pool.remove("bob") if "bob" in pool else [],
}


@pytest.mark.parametrize("way", WAYS)
def test_ctrl_c_at_any_place_of_what_a_pool_does_for_all_comes_to_the_same_when_it_is_done_again(core, way):
    def begun():
        pool = Performers(SETTINGS, most=2)
        for name in ("ann", "bob"):
            pool.announce(name, core.skeleton(4))
            pushed(pool, core, name, 0, slice(0, 50))
        return pool

    def told(events):
        return sorted(core.lines([e for e in events if getattr(e, "event", "") != "reset"]))

    whole = begun()
    expected = told(WAYS[way](whole) + whole.end_takes())
    for after in PLACES:
        pool, strike, events = begun(), Striking(after), []
        with strike:
            events = WAYS[way](pool)
        if not strike.has_struck:
            break
        cut = Performers(SETTINGS, most=2)
        cut.restore(pool.snapshot(), pool.lasting())
        for one in (pool, cut):
            assert told(events + WAYS[way](one) + one.end_takes()) == expected
    assert after > 3


def test_a_pool_s_own_change_is_finished_after_ctrl_c(core):
    for after in PLACES:
        pool, strike = Performers(SETTINGS), Striking(after)
        for name in ("ann", "bob"):
            pool.announce(name, core.skeleton(4))
        with strike:
            pool.change(window=0.1)
        if not strike.has_struck:
            break
        pool.end_takes()
        assert len({pool.settings.window, *(pool[name].settings.window for name in pool.names)}) == 1
    assert after > 10


def test_a_pool_that_is_dropped_takes_no_memory_until_the_collector_comes_by(core):
    gc.collect()
    gc.disable()
    try:
        pool = Performers(SETTINGS)
        pool.announce("ann", core.skeleton(4))
        pushed(pool, core, "ann", 0, slice(0, 50))
        gone = weakref.ref(pool)
        left = pool["ann"]
        del pool
        assert gone() is None
        left.change(limbs="arm=" + ",".join(core.skeleton(4).names[1:3]))
        assert left.limbs == ("arm",)
    finally:
        gc.enable()
