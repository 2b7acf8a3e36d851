"""Nothing is left half done: exceptions between any two steps, ends of takes in chunks, ids and numbers afterwards."""

import functools
import random
from collections import Counter

import numpy as np
import pytest

from checks.interrupts.alone import Tally, live
from checks.interrupts.striking import Striking
from mossar_adapters.demo import performance
from mossar_stream import (
    FrameError,
    KeyFrameEvent,
    MoveEvent,
    Moves,
    Performers,
    RepetitionEvent,
    Segmenter,
    Settings,
    SettingsError,
    Skeleton,
    StreamEvent,
)
from mossar_stream.core.row import region


@functools.cache
def taught():
    shown = performance(7, fps=60.0, seconds=4.0, moves=["rest:1", "punch_left", "rest:1"])
    moves = Moves(shown.skeleton)
    moves.add("punch", shown.frames.positions, fps=60)
    return moves


def spans(events):
    """Return the takes that events report, and fail if one lies outside its take, or a revision is missing."""
    take, takes, revisions = None, [], {}
    for event in events:
        if isinstance(event, StreamEvent):
            if event.event == "started":
                assert take is None
                take = event.take
                takes.append(take)
            elif event.event == "ended":
                assert event.take == take
                take = None
            continue
        assert event.take == take
        if hasattr(event, "rev"):
            assert event.rev == revisions.get((type(event), event.id), 0) + 1
            revisions[type(event), event.id] = event.rev
    return takes


@pytest.mark.parametrize("chunk", [1, 16])
@pytest.mark.parametrize("chosen", [{}, {"limbs": True}, {"limbs": True, "repetitions": True}], ids=str)
def test_ctrl_c_between_any_two_steps_leaves_everything_in_order(chosen, chunk):
    take = performance(5, fps=60.0, seconds=12.0, moves=["punch_left", "squat", "wave_left"] * 4)
    positions, times, rng = take.frames.positions, np.array(take.frames.times), random.Random(chunk)
    segmenter = Segmenter(take.skeleton, Settings(**chosen), moves=taught() if rng.random() < 0.7 else None)
    events, struck, k = [], 0, 0
    while k < len(times) - chunk:
        before, k = k, k + chunk
        what = rng.choice(["push"] * 12 + ["end", "level", "change", "gap", "snapshot"])
        strike = Striking(rng.randint(1, 30))
        with strike:
            if what == "gap":
                times[before:] += rng.choice([-3.0, 3.0])
            if what == "end":
                events += segmenter.end_take()
            elif what == "level":
                segmenter.level = rng.choice([0.1, 0.5, "motion"])
            elif what == "change":
                events += segmenter.change(sig_threshold=rng.choice([0.02, 0.1]))
            elif what == "snapshot":
                segmenter.snapshot()
            else:
                place = before if chunk == 1 else slice(before, k)
                events += segmenter.push(positions[place], times[place])
        struck += strike.has_struck
        if strike.has_struck and rng.random() < 0.2:
            segmenter = Segmenter.restore(segmenter.snapshot())
    takes = spans(events + segmenter.end_take())
    assert takes == sorted(set(takes))
    assert len(takes) > 1
    assert struck > 20


def test_after_ctrl_c_events_are_those_of_a_run_with_or_without_what_it_cut_short():
    tally = Tally(Counter(), Counter(), [])
    for seed in (3, 4, 15, 17, 19, 20):
        live(seed, tally, compared=0.7)
    assert not tally.wrong
    assert len(tally.compared) >= 6
    assert sum(tally.compared.values()) > 15


def test_ctrl_c_within_a_look_at_repetitions_leaves_them_in_order():
    take = performance(5, fps=30.0, seconds=14.0, moves=["squat"] * 8)
    positions, times = take.frames.positions, take.frames.times
    whole, looks, before = Segmenter(take.skeleton, Settings(repetitions=True)), {}, 0
    for k, (position, time) in enumerate(zip(positions, times, strict=True)):
        tells = any(isinstance(e, RepetitionEvent) for e in whole.push(position, time))
        before, looked = int(region(whole.row.memory, "counted")["analysed"][0]), before
        if looked != before:
            looks.setdefault(tells, []).append(k)
    assert len(looks[False]) > 2, "all looks change what is counted"
    for k in (*looks[False][-4:-1], *looks[True][:3]):
        fresh = Segmenter(take.skeleton, Settings(repetitions=True))
        begin, blob = fresh.push(positions[:k], times[:k]), fresh.snapshot()
        expected = [e for e in fresh.push(positions[k:], times[k:]) if isinstance(e, RepetitionEvent)]
        for after in range(1, 1000):
            segmenter, events, strike = Segmenter.restore(blob), list(begin), Striking(after)
            with strike:
                events += segmenter.push(positions[k], times[k])
            if not strike.has_struck:
                break
            segmenter = Segmenter.restore(segmenter.snapshot())
            events += segmenter.push(positions[k + 1 :], times[k + 1 :])
            spans(events)
            last = [e for e in events if isinstance(e, RepetitionEvent)][-1]
            assert abs(last.total - expected[-1].total) <= 1  # the frame may be left out
        assert after > 1


LEVELS = ("motion", "posture", "cluster")


@pytest.mark.parametrize("first", LEVELS)
@pytest.mark.parametrize("second", LEVELS)
@pytest.mark.parametrize("counting", [False, True])
def test_limbs_follow_a_body_that_begins_or_ceases_to_count(first, second, counting):
    take = performance(7, fps=30.0, seconds=6.0, moves=["wave_left"] * 4)
    positions, times = take.frames.positions, take.frames.times
    segmenter = Segmenter(take.skeleton, Settings(level=first, limbs=True, repetitions=counting))
    events = segmenter.push(positions[:90], times[:90])
    for k, changes in (
        (90, {"level": second}),
        (120, {"repetitions": not counting}),
        (150, {"level": first}),
    ):
        events += segmenter.change(**changes)
        events += segmenter.push(positions[k], times[k])
        events += segmenter.push(positions[k + 1 : k + 30], times[k + 1 : k + 30])
    assert spans(events + segmenter.end_take())


@pytest.mark.parametrize("seconds", [3.0, -100.0])
def test_a_move_is_final_before_its_take_has_ended(seconds):
    take = performance(7, fps=60.0, seconds=6.0, moves=["rest:1", "punch_left", "rest:2"])
    positions, times = take.frames.positions, np.array(take.frames.times)
    segmenter = Segmenter(take.skeleton, Settings(), moves=taught())
    whole = [segmenter.push(position, time) for position, time in zip(positions, times, strict=True)]
    confirmed = next(k for k, events in enumerate(whole) if any(isinstance(e, MoveEvent) for e in events))
    times[confirmed + 1 :] += seconds
    found = {}
    for size in (1, 7, 1000):
        segmenter = Segmenter(take.skeleton, Settings(), moves=taught())
        places = [slice(at, at + size) for at in range(0, len(times), size)]
        found[size] = [e for place in places for e in segmenter.push(positions[place], times[place])]
    assert found[1] == found[7] == found[1000]
    spans(found[1])
    said = [
        e.status if isinstance(e, MoveEvent) else e.event
        for e in found[1]
        if isinstance(e, MoveEvent | StreamEvent)
    ]
    assert said[:5] == ["started", "confirmed", "final", "ended", "started"]


def test_a_take_that_begins_within_a_chunk_begins_there_whatever_the_last_time_is():
    take = performance(3, fps=30.0, seconds=6.0)
    positions, times = take.frames.positions, np.array(take.frames.times)
    positions[60:80] += 500.0  # and the performer stands elsewhere
    times[60:80] += 3.0
    found = []
    for size in (1, 64, 1000):
        segmenter = Segmenter(take.skeleton, Settings())
        places = [slice(at, at + size) for at in range(0, len(times), size)]
        found.append([e for place in places for e in segmenter.push(positions[place], times[place])])
    assert found[0] == found[1] == found[2]
    assert len(spans(found[0])) == 3


@pytest.mark.parametrize("moves", [True, False])
def test_the_number_of_the_first_frame_holds_for_takes_within_the_chunk(moves):
    take = performance(3, fps=30.0, seconds=10.0, moves=["punch_left", "kick_right"] * 4)
    positions, times = take.frames.positions, np.array(take.frames.times)
    times[150:] += 5.0
    found = []
    for size in (50, 300):
        segmenter = Segmenter(take.skeleton, Settings(), moves=taught() if moves else None)
        places = [slice(at, at + size) for at in range(0, len(times), size)]
        events = [
            e for p in places for e in segmenter.push(positions[p], times[p], first_frame=1000 + p.start)
        ]
        found.append([e.id for e in events if isinstance(e, KeyFrameEvent)])
    assert found[0] == found[1]
    assert all(int(key.rpartition("/")[2]) >= 1000 for key in found[1])


def test_snapshots_do_not_change_the_order_of_what_limbs_repeat():
    take = performance(7, fps=30.0, seconds=15.0, moves=["wave_left", "squat"] * 8)
    positions, times = take.frames.positions, take.frames.times
    found = []
    for every in (10**9, 1, 7):
        segmenter, events = Segmenter(take.skeleton, Settings(limbs=True, repetitions=True)), []
        for k, (position, time) in enumerate(zip(positions, times, strict=True)):
            if k % every == every - 1:
                segmenter = Segmenter.restore(segmenter.snapshot())
            events += segmenter.push(position, time)
        found.append(events)
    assert found[0] == found[1] == found[2]


def test_announcing_what_cannot_be_followed_changes_nothing():
    pool = Performers(Settings(), most=2)
    for name in ("ann", "ben"):
        pool.announce(name, Skeleton(("hip", "hand"), (-1, 0)))
    pool.change("ann", limbs="arm=hand")
    with pytest.raises(FrameError):
        pool.announce("ann", Skeleton(("head", "neck"), (-1, 0)))
    with pytest.raises(ValueError, match=r"fps|rate"):
        pool.announce("eve", Skeleton(("hip", "hand"), (-1, 0)), fps=-1.0)
    assert pool.names == ("ann", "ben")
    assert pool["ann"].settings.limbs == "arm=hand"


@pytest.mark.parametrize("name", ["body", "move", "activity", "step"])
def test_no_limb_is_called_as_what_stands_at_its_place_in_other_ids(name):
    with pytest.raises(SettingsError, match="activity"):
        Settings(limbs=f"{name}=hand")
