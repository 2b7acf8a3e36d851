"""Many performers: each is as if alone."""

import numpy as np
import pytest

from mossar_stream import FrameError, Frames, Performers, Segmenter, Settings, SettingsError, Skeleton

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
    resolved = [pool[name]._plan.settings for name in pool.names]
    assert resolved[0] == resolved[1] == Settings(level="cluster").resolved()
    pool.change(level="motion")
    pool.announce("eve", core.skeleton(4))
    assert {pool[name].level for name in pool.names} == {"motion"}
    assert {pool[name]._header["level"].item() for name in pool.names} == {
        pool["ann"]._header["level"].item()
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
