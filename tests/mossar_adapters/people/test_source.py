import itertools
import json

import numpy as np
import pytest

from checks.fuzz.recordings import WRITERS
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.people import PeopleSource
from mossar_adapters.source import Departure, Meta, Occupant
from mossar_adapters.urls import open_source
from mossar_stream import Frames, Skeleton


def cut(k, i):
    """Ids that are exchanged, and cut in the very frame, of two people who are there all the time."""
    if i < 100:
        return ("p1", "p2")[k]
    if i < 200:
        return ("p2", "p1")[k]
    return ("p2", "p5")[k] if i < 300 else ("p8", "p5")[k]


@pytest.mark.parametrize("chunk", [1, 7, 64, 600])
def test_slots_are_given_in_the_order_of_times_whatever_the_chunks(tracked, played, chunk):
    slots, others = played(tracked(cut, chunk=chunk))
    assert (slots[0] == 1).all()
    assert (slots[1] == 2).all()
    assert sorted((o.performer, o.id) for o in others) == [
        ("p1", "p1"),
        ("p1", "p2"),
        ("p1", "p8"),
        ("p2", "p1"),
        ("p2", "p2"),
        ("p2", "p5"),
    ]


@pytest.mark.parametrize("chunk", [1, 7, 64])
def test_of_two_who_come_in_one_moment_the_one_announced_first_is_the_first(tracked, played, chunk):
    items = tracked(cut, chunk=chunk)
    metas, frames = ([item for item in items if isinstance(item, kind)] for kind in (Meta, Frames))
    # Chunks filled later first.
    frames.sort(key=lambda item: (item.times[0] // (chunk / 60), item.performer == "p1"))
    slots, _ = played([*metas, *frames])
    assert (slots[0] == 1).all()
    assert (slots[1] == 2).all()


def test_all_that_is_known_goes_on_at_once(tracked):
    items = tracked(lambda k, _: f"p{k + 1}", frames=10)
    seen = []

    class Live:
        name, live = "live", True

        def items(self):
            for item in items:
                seen.append(item)
                yield item

        def close(self):
            pass

    for item in PeopleSource(Live(), 2).items():
        if isinstance(item, Frames) and item.times[0] > 0:
            assert item.times[0] == seen[-1].times[0]


def test_a_hidden_person_goes_on_under_another_id(tracked, played):
    def ids(k, i):
        if k == 0 and 200 <= i < 290:
            return None
        return "p2" if k else ("p1" if i < 200 else "p7")

    slots, others = played(tracked(ids))
    assert set(slots[0]) == {0, 1}
    assert (slots[0] == 0).sum() == 90
    assert others[-1] == Occupant("p1", "p7")


def test_frames_of_an_id_that_is_looked_at_are_not_lost(tracked, played, bodies):
    moved = bodies.copy()
    moved[:, 500:, :, 2] += 1.0

    def ids(k, i):
        return None if 200 <= i < 500 else f"p{k + 1}" if i < 200 else f"p{9 - k}"

    slots, _ = played(tracked(ids, frames=1000, positions=moved), frames=1000, positions=moved)
    assert (slots[0, 500:] == 1).all()
    assert (slots[1, 500:] == 2).all()


def test_a_person_who_has_left_ends_the_take_only_if_nobody_goes_on(tracked, script):
    items = tracked(lambda _k, i: "p1" if i < 100 else "p7", frames=200, people=1)
    place = next(i for i, item in enumerate(items) if item.performer == "p7" and isinstance(item, Frames))
    items.insert(place, Departure("p1", "lost"))
    assert [o for o in PeopleSource(script(items), 2).items() if isinstance(o, Departure)] == []
    items = [*items[:place], Departure("p1", "lost")]
    assert list(PeopleSource(script(items), 2).items())[-1] == Departure("p1", "lost")


def test_another_skeleton_is_announced(bodies, script):
    small = Skeleton(SKELETON.names[:5], (-1, 0, 1, 2, 3))
    items = [
        Meta("p4", SKELETON),
        Frames(bodies[0, :5], np.arange(5) / 60, performer="p4"),
        Meta("p4", small),
        Frames(bodies[0, 5:10, :5], np.arange(5, 10) / 60, performer="p4"),
    ]
    found = list(PeopleSource(script(items), 1).items())
    metas = [item for item in found if isinstance(item, Meta)]
    assert [(meta.performer, meta.skeleton) for meta in metas] == [("p1", SKELETON), ("p1", small)]
    assert sum(len(item) for item in found if isinstance(item, Frames)) == 10


def test_an_id_with_a_clock_of_its_own_goes_on_with_the_others(tracked, script):
    items = tracked(lambda _k, i: "p1" if i < 300 else "p7", frames=400, people=1)
    late = [
        Frames(i.positions, i.times - 300 / 60, performer="p7")
        if isinstance(i, Frames) and i.performer == "p7"
        else i
        for i in items
    ]
    times = [float(i.times[0]) for i in PeopleSource(script(late), 1).items() if isinstance(i, Frames)]
    assert (np.diff(times) >= 0).all()
    assert len(times) == 400


# Of a sender that was started later, or earlier.
@pytest.mark.parametrize("clock", [-200 / 60, 500.0, 500.005])
def test_a_second_sender_in_the_same_place_is_one_more_person(tracked, bodies, clock, script, monkeypatch):
    ticks = itertools.count()  # frames come as quickly as they were made
    monkeypatch.setattr("mossar_adapters.people.source.time.monotonic", lambda: next(ticks) / 60)
    same = np.stack([bodies[0], bodies[0] + np.float32([0.02, 0, 0])])  # avatars stand in the middle
    items = [
        Frames(i.positions, i.times + clock, performer="p2")
        if isinstance(i, Frames) and i.performer == "p2"
        else i
        for i in tracked(lambda k, i: ("p1", "p2" if i >= 200 else None)[k], positions=same)
    ]
    found = [i for i in PeopleSource(script(items), 2).items() if isinstance(i, Frames)]
    for slot, k, first in (("p1", 0, 0), ("p2", 1, 200)):
        assert np.array_equal(
            np.concatenate([f.positions for f in found if f.performer == slot]), same[k, first:600]
        )
    assert (np.diff([f.times[0] for f in found if f.performer == "p2"]) > 0).all()


@pytest.mark.parametrize("live", [True, False])
def test_an_id_that_is_cut_after_the_clock_was_set_back_goes_on(tracked, script, live):
    def later(item):
        if not isinstance(item, Frames) or item.times[0] >= 5:
            return item
        return Frames(item.positions, item.times + 100, performer=item.performer)

    items = tracked(lambda k, i: ("p1", "p2" if i < 450 else "p5")[k])
    source = PeopleSource(script([*map(later, items)], live=live), 2)
    found = [item for item in source.items() if isinstance(item, Frames)]
    for slot in ("p1", "p2"):
        steps = np.diff([item.times[0] for item in found if item.performer == slot])
        assert len(steps) == 599
        assert np.allclose(np.delete(steps, 299), 1 / 60)
        assert steps[299] == pytest.approx(-100 + 1 / 60)


def test_a_clock_that_is_set_ahead_of_the_others_sets_none_back(tracked, script):
    items = [
        Frames(i.positions, i.times + 1.5, performer="p2")
        if isinstance(i, Frames) and i.performer == "p2" and i.times[0] >= 5
        else i
        for i in tracked(lambda k, _i: f"p{k + 1}")
    ]
    found = list(PeopleSource(script(items), 2).items())
    assert {(i.performer, i.id) for i in found if isinstance(i, Occupant)} == {("p1", "p1"), ("p2", "p2")}
    for slot, ahead in (("p1", 0), ("p2", 1.5)):
        times = [i.times[0] for i in found if isinstance(i, Frames) and i.performer == slot]
        assert np.allclose(times, np.where(np.arange(600) < 300, 0, ahead) + np.arange(600) / 60)


def test_a_sender_with_a_clock_of_its_own_that_is_started_anew_stays_with_the_others(tracked, script):
    items = [
        Frames(i.positions, i.times + (500 if i.times[0] < 5 else -5), performer="p2")
        if isinstance(i, Frames) and i.performer == "p2"
        else i
        for i in tracked(lambda k, i: ("p1", "p2" if i >= 60 else None)[k])
    ]
    found = [i for i in PeopleSource(script(items), 2).items() if isinstance(i, Frames)]
    for slot, count in (("p1", 600), ("p2", 540)):
        times = np.array([i.times[0] for i in found if i.performer == slot])
        assert len(times) == count
        assert np.allclose(times, np.arange(600 - count, 600) / 60, atol=0.2)


def test_a_chunk_that_lies_behind_the_others_is_no_clock_that_was_set_back(tracked, played):
    slots, others = played(tracked(lambda k, i: ("p1", "p2" if i < 315 else "p5")[k], chunk=150))
    assert (slots[0] == 1).all()
    assert (slots[1] == 2).all()
    assert [(o.performer, o.id) for o in others] == [("p1", "p1"), ("p2", "p2"), ("p2", "p5")]


def away_and_back(k, i):
    """Ids of one person who stays and of two who are away for more than 2 s."""
    return "p1" if not k else f"p{k + 1}" if i < 100 else f"p{k + 7}" if i >= 300 else None


def test_frames_of_an_id_that_is_looked_at_when_the_clock_is_set_back_are_not_lost(tracked, bodies, script):
    alike = np.stack([bodies[0] + np.float32([2 * k, 0, 0]) for k in range(3)])
    items = tracked(away_and_back, people=3, frames=310, positions=alike)
    again = tracked(lambda _k, _i: "p1", frames=60, people=1)
    source = PeopleSource(script([*items, *again], live=False), 3)
    assert sum(len(item) for item in source.items() if isinstance(item, Frames)) == 310 + 2 * 110 + 60


def test_the_only_slot_goes_forward_in_time(tracked, bodies, script):
    alike = np.stack([bodies[0] + np.float32([2, 0, 4 - k]) for k in range(3)])  # the last is the nearest
    items = tracked(
        lambda k, i: None if not k and i > 410 else away_and_back(k, i), people=3, positions=alike
    )
    found = [i for i in PeopleSource(script(items), "nearest").items() if isinstance(i, Frames)]
    assert (np.diff(np.concatenate([item.times for item in found])) > 0).all()


def test_a_slow_camera_reports_a_person_once(bodies, script, caplog):
    items = [
        Frames(bodies[k, 20 * i : 20 * i + 1], np.array([i / 3]), performer=f"p{k + 7}")
        for i in range(30)
        for k in range(2)
    ]
    with caplog.at_level("INFO", "mossar.people"):
        found = list(PeopleSource(script(items), 2).items())
    assert sum(isinstance(item, Frames) for item in found) == 60
    assert [record.message for record in caplog.records] == ["script: p1 is id 7", "script: p2 is id 8"]


def test_memory_does_not_grow_with_ids_that_show_nobody(bodies, script):
    empty = np.full((1, *bodies.shape[2:]), np.nan, np.float32)
    items = [Frames(empty, np.array([i / 60]), performer=f"x{i}") for i in range(1000)]
    source = PeopleSource(script(items), 2)
    assert list(source.items()) == []
    assert len(source._held) <= 256


def test_a_run_that_goes_on_skips_what_was_used(tracked, script):
    class File(type(script([]))):
        def resume(self, _position):
            raise AssertionError("the source's ids are others")

    items = tracked(cut, chunk=64)
    source = PeopleSource(File(items, live=False), 2)
    source.resume({"p1": 350, "p2": 600})
    found = [item for item in source.items() if isinstance(item, Frames)]
    assert {item.performer for item in found} == {"p1"}
    assert sum(map(len, found)) == 250
    assert found[0].times[0] == pytest.approx(350 / 60)


def test_recordings_come_in_order_of_time_though_their_readers_hold_chunks_back(bodies, tmp_path):
    maps = [{"v": 1, "type": "meta", "performer": n, "names": SKELETON.names, "parents": SKELETON.parents,
             "root": SKELETON.root, "unit": "m"} for n in ("p7", "p9", "p12")]  # fmt: skip
    for i in range(700):
        ids = ("p7", "p9") if i < 300 else ("p9", "p7") if i < 500 else ("p9", "p12")
        maps += [
            {"v": 1, "type": "frame", "performer": ids[k], "t": i / 60, "xyz": bodies[k, i].tolist()}
            for k in range(2)
        ]
    path = tmp_path / "two.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in maps))
    found = [item for item in open_source(str(path), people=2).items() if isinstance(item, Frames)]
    for k, name in enumerate(("p1", "p2")):
        own = [item for item in found if item.performer == name]
        assert np.array_equal(np.concatenate([item.positions for item in own]), bodies[k, :700])


def test_the_stream_of_an_xdf_recording_gets_the_first_slot(tmp_path):
    name, content = WRITERS["xdf"]
    path = tmp_path / name
    path.write_bytes(content())
    plain = [item for item in open_source(str(path)).items() if isinstance(item, Frames)]
    slots = [item for item in open_source(str(path), people=2).items() if isinstance(item, Frames)]
    assert {item.performer for item in slots} == {"p1"}
    assert np.array_equal(
        np.concatenate([item.positions for item in slots]), np.concatenate([item.positions for item in plain])
    )
