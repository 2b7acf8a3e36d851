import sys

import numpy as np
import pytest

from mossar_adapters.demo.body import SKELETON
from mossar_adapters.people import REFUSED, UNDECIDED, Slots
from mossar_stream import FrameError, SettingsError


@pytest.mark.parametrize("people", [0, -1, 65])
def test_there_are_1_to_64_slots(people):
    with pytest.raises(SettingsError, match="1 to 64"):
        Slots(people)


@pytest.mark.parametrize("people", [2.5, "2", "far", None, True, float("nan"), [2]])
def test_other_numbers_of_people_are_refused(people):
    with pytest.raises(SettingsError, match="nearest or first"):
        Slots(people)


def test_numbers_of_numpy_are_numbers(bodies):
    slots = Slots(np.int64(1), remember=np.float32(5), watch=np.int32(1))
    assert slots.follow("p1", bodies[0, 0], np.float32(0.5)) == "p1"
    assert slots.names == ("p1",)
    assert Slots(2.0).names == ("p1", "p2"), "OSC clients such as Pure Data send all numbers as floats"


@pytest.mark.parametrize("seconds", [-1, float("nan"), "5", None, True])
@pytest.mark.parametrize("name", ["remember", "watch"])
def test_durations_are_numbers_from_0(name, seconds):
    with pytest.raises(SettingsError, match=name):
        Slots(2, **{name: seconds})


POSE = np.zeros((len(SKELETON), 3))
WRONG = {
    "an id that is no text": (7, POSE, 0.1),
    "no time": ("7", POSE, None),
    "a time without a number": ("7", POSE, float("nan")),
    "an endless time": ("7", POSE, float("inf")),
    "a time as text": ("7", POSE, "0.1"),
    "words": ("7", [["a", "b", "c"]], 0.1),
    "one joint's coordinates": ("7", [0, 0, 0], 0.1),
    "two coordinates": ("7", POSE[:, :2], 0.1),
    "no joints": ("7", [], 0.1),
    "several poses": ("7", POSE[None], 0.1),
    "other joints than announced": ("7", POSE[:5], 0.1),
}


@pytest.mark.parametrize("given", WRONG.values(), ids=WRONG)
def test_wrong_input_is_refused_and_changes_nothing(bodies, given):
    slots, untouched = Slots(2), Slots(2)
    found = []
    for one in (slots, untouched):
        for k in range(2):
            one.announce(str(k + 7), SKELETON)
            one.follow(str(k + 7), bodies[k, 0], 0.0)
        if one is slots:
            with pytest.raises(FrameError):
                one.follow(*given)
        found.append([one.follow(str(8 - k), bodies[k, 1], 1 / 60) for k in range(2)])
    assert found[0] == found[1] == ["p1", "p2"]
    assert slots.table() == untouched.table()


@pytest.mark.parametrize("far", [1e30, -3e38, float("inf")])
def test_what_is_too_far_off_is_missing(bodies, far):
    damaged, gone = Slots(2), Slots(2)
    for i in range(30):
        for k in range(2):
            pose, holes = bodies[k, i].copy(), bodies[k, i].copy()
            pose[i % 5], holes[i % 5] = far, np.nan
            named = [one.follow(str(k), given, i / 60) for one, given in ((damaged, pose), (gone, holes))]
            assert named == [f"p{k + 1}"] * 2
    assert damaged.table() == gone.table()


def test_a_skeleton_is_announced_for_an_id():
    for ident, skeleton in ((7, SKELETON), ("7", "kinect")):
        with pytest.raises(FrameError, match="announced with a Skeleton"):
            Slots(2).announce(ident, skeleton)


FORMS = {
    "float32": lambda pose: pose,
    "float64": lambda pose: pose.astype(np.float64),
    "backwards in memory": lambda pose: pose[::-1].copy()[::-1],
    "lists": lambda pose: pose.tolist(),
    "a masked array": np.ma.MaskedArray,
    "rounded to centimetres": lambda pose: (pose * 100).round() / 100,
}


@pytest.mark.parametrize("form", FORMS)
def test_poses_have_any_form(bodies, form):
    slots = Slots(2)
    for i in range(60):
        for k in range(2):
            given = FORMS[form](bodies[k, i])
            ident = "ab"[k] if i < 30 else "ba"[k]
            assert slots.follow(ident, given, i / 60) == ("p1", "p2")[k]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("far", [np.inf, -np.inf, 1e12])
def test_joints_too_far_off_to_be_true_are_missing(bodies, far):
    slots = Slots(2)
    for i in range(120):
        for k in range(2):
            pose = bodies[k, i].astype(np.float64)
            pose[3] = far
            pose[i % 7] = far if i % 5 == 0 else pose[i % 7]
            ident = "ab"[k] if i < 60 else "ba"[k]
            assert slots.follow(ident, pose, i / 60) == ("p1", "p2")[k]


def test_a_known_id_keeps_its_slot_and_a_third_is_refused(bodies):
    slots = Slots(2)
    for i in range(200):
        found = [slots.follow(f"p{k}", bodies[k, i], i / 60) for k in range(3)]
        assert found == ["p1", "p2", REFUSED]
    assert [change.how for change in slots.changes()] == ["new", "new", "refused"]
    assert slots.refused == 200


def test_ids_that_are_exchanged_follow_the_bodies(bodies):
    slots = Slots(2)
    for i in range(400):
        ids = ("p1", "p2") if i < 200 else ("p2", "p1")
        assert [slots.follow(ids[k], bodies[k, i], i / 60) for k in range(2)] == ["p1", "p2"]
    assert [change.how for change in slots.changes()][2:] == ["swap", "place"]


@pytest.mark.parametrize("hidden", [60, 300])
def test_a_leap_on_the_spot_is_no_exchange_with_somebody_hidden_whose_bones_fit_better(bodies, hidden):
    one, other = bodies[0].astype(float), bodies[2]
    middle = one.mean(axis=1, keepdims=True)
    leapt = middle + (one - middle) * (1.1 / 0.92) + [0.25, 0.0, 0.1]  # as tall as the other
    slots = Slots(4)
    for ident in ("7", "9"):
        slots.announce(ident, SKELETON)
    for i in range(120):
        assert slots.follow("7", one[i], i / 60) == "p1"
        assert slots.follow("9", other[i], i / 60) == "p2"
    for i in range(120, 120 + hidden):
        assert slots.follow("7", one[i], i / 60) == "p1"
    for i in range(120 + hidden, 180 + hidden):
        assert slots.follow("7", leapt[i], i / 60) == "p1"
        assert slots.follow("9", other[i], i / 60) == "p2"


def test_a_new_id_where_another_was_lost_goes_on_in_its_slot(bodies):
    slots = Slots(3)
    for i in range(400):
        if not 200 <= i < 260:  # 1 s
            assert slots.follow("p1" if i < 200 else "p9", bodies[0, i], i / 60) == "p1"
        assert slots.follow("p2", bodies[1, i], i / 60) == "p2"
    last = slots.changes()[-1]
    assert (last.slot, last.id, last.how, round(last.away, 1)) == ("p1", "p9", "place", 1.0)


def test_people_who_come_back_elsewhere_are_known_by_their_bones(bodies):
    slots = Slots(2)
    for name in ("p1", "p2", "p3", "p4"):
        slots.announce(name, SKELETON)
    for i in range(300):
        assert [slots.follow(f"p{k + 1}", bodies[k, i], i / 60) for k in range(2)] == ["p1", "p2"]
    elsewhere = np.float32([0.2, 0, 1.4])
    seen: dict[str, set[str | None]] = {"p3": set(), "p4": set()}
    for i in range(300, 500):
        time = i / 60 + 10
        seen["p3"].add(slots.follow("p3", bodies[1, i] + elsewhere, time))
        seen["p4"].add(slots.follow("p4", bodies[0, i] - elsewhere, time))
    assert seen["p3"] - {UNDECIDED} == {"p2"}
    assert seen["p4"] - {UNDECIDED} == {"p1"}


def test_nobody_is_remembered_for_longer_than_wanted(bodies):
    slots = Slots(1, remember=5.0)
    for k, time in ((0, 0.0), (0, 3.0), (0, 20.0)):
        assert slots.follow(f"p{time}", bodies[k, 0], time) == "p1"
    assert [change.another for change in slots.changes()] == [False, False, True]


def test_the_nearest_has_the_only_slot(bodies):
    slots = Slots("nearest")
    assert slots.follow("p1", bodies[1, 0], 0.0) == "p1"
    assert slots.follow("p2", bodies[0, 0], 0.0) == REFUSED  # another was in the slot in this frame
    assert slots.follow("p1", bodies[1, 1], 1 / 60) == REFUSED
    assert slots.follow("p2", bodies[0, 1], 1 / 60) == "p1"
    assert [(c.id, c.another) for c in slots.changes()] == [("p1", False), ("p2", True)]


def test_the_first_has_the_only_slot_until_it_has_left(bodies):
    slots = Slots("first")
    got = {"p1": [], "p2": []}
    for i in range(400):
        if i < 100:
            got["p1"].append(slots.follow("p1", bodies[1, i], i / 60))
        got["p2"].append(slots.follow("p2", bodies[0, i], i / 60))
    assert set(got["p1"]) == {"p1"}
    assert set(got["p2"][:200]) == {REFUSED}
    assert set(got["p2"][240:]) == {"p1"}


def test_two_people_are_exchanged_by_hand(bodies):
    slots = Slots(2)
    for i in range(50):
        for k in range(2):
            slots.follow(f"p{k + 1}", bodies[k, i], i / 60)
    slots.exchange("p1", "p2")
    assert slots.follow("p1", bodies[0, 50], 50 / 60) == "p2"
    assert slots.follow("p2", bodies[1, 50], 50 / 60) == "p1"
    with pytest.raises(SettingsError, match="no slot 'p3'; there are p1, p2"):
        slots.exchange("p1", "p3")


def test_a_pinned_slot_is_kept_for_its_person(bodies):
    slots = Slots(2, remember=1.0, watch=0.0)
    for k in range(2):
        slots.follow(f"p{k + 1}", bodies[k, 0], 0.0)
    slots.pin("p1")
    assert slots.follow("p9", bodies[2, 0], 100.0) == "p2"
    assert slots.table()[0] == {"slot": "p1", "id": "p1", "there": False, "pinned": True}


def test_a_pinned_slot_is_not_given_to_somebody_of_another_size(bodies):
    for people, slot in ((1, REFUSED), (2, "p2")):
        slots = Slots(people)
        for ident in ("7", "8", "9"):
            slots.announce(ident, SKELETON)
        for i in range(200):
            slots.follow("7", bodies[0, i], i / 60)
            if people == 2:
                slots.follow("8", bodies[1, i], i / 60)
        slots.pin("p1")
        seen = {slots.follow("9", bodies[2, i] * 1.4, 20 + i / 60) for i in range(200)}
        assert seen - {UNDECIDED} == {slot}
        assert slots.table()[0]["id"] == "7"


def test_who_is_hidden_for_a_moment_is_found_by_place_though_nobody_is_remembered(bodies):
    slots = Slots(2, remember=0.0)
    for i in range(120):
        for k in range(2):
            if k or not 60 <= i < 90:
                ident = f"{k}" if i < 60 else f"{k + 2}"
                assert slots.follow(ident, bodies[k, i], i / 60) in {f"p{k + 1}", UNDECIDED}
    assert not any(change.another for change in slots.changes())


def test_an_id_without_a_joint_takes_no_slot(bodies):
    slots = Slots(2)
    empty = np.full_like(bodies[0, 0], np.nan)
    for i in range(300):
        assert slots.follow("ghost", empty, i / 60) is UNDECIDED
        for k in range(2):
            assert slots.follow(f"{k}", bodies[k, i], i / 60) == f"p{k + 1}"
    assert slots.follow("ghost", bodies[2, 0], 5.0) == REFUSED
    assert slots.follow("ghost", empty, 5.02) == REFUSED


def test_an_id_without_a_joint_is_not_in_the_slot_that_another_id_takes(bodies):
    slots = Slots(2)
    empty = np.full_like(bodies[0, 0], np.nan)
    for i in range(60):
        poses = [("a", empty if i > 50 else bodies[0, i]), ("b", bodies[1, i])]
        assert slots.decide(i / 60, poses) == ["p1", "p2"]
    for i in range(60, 65):  # a's person goes on as b, and a has no joint
        assert slots.decide(i / 60, [("b", bodies[0, i]), ("a", empty)]) == ["p1", UNDECIDED]


@pytest.mark.parametrize("people", [1, 2])
def test_who_is_elsewhere_after_the_clock_was_set_back_keeps_the_slot(bodies, people):
    slots = Slots(2)
    for start, i in ((100, 0), (0, 400)):  # a recording that is played again from another place
        for n in range(100):
            for k in range(people):
                pose = bodies[k, i + n] + np.float32([0, 0, start / 100])
                assert slots.follow(f"{k + 7}", pose, start + n / 60) == f"p{k + 1}"
    assert {change.how for change in slots.changes()} == {"new"}


@pytest.mark.parametrize("people", ["nearest", "first"])
def test_the_only_slot_is_given_again_after_the_clock_was_set_back(bodies, people):
    slots = Slots(people)
    for i in range(60):
        assert slots.follow("7", bodies[1, i], 100 + i / 60) == "p1"
    found = [slots.follow("8", bodies[0, i], i / 60) for i in range(240)]
    assert set(found[150:]) == {"p1"}


def test_poses_are_not_kept_by_reference(bodies):
    slots, pose = Slots(2), bodies[0, 0].copy()
    slots.follow("p1", pose, 0.0)
    pose += 100
    assert slots.follow("p2", bodies[0, 1], 1 / 60) == "p1"


def test_missing_joints_and_empty_frames_keep_the_slot(bodies):
    slots = Slots(2)
    for i in range(200):
        pose = bodies[0, i].copy()
        pose[(i % 7) :: 5] = np.nan
        if i % 11 == 10:
            pose[:] = np.nan
        assert slots.follow("p1", pose, i / 60) == "p1"


def test_memory_does_not_grow_with_ids(bodies):
    slots = Slots(1)
    for i in range(3000):
        slots.follow("p1", bodies[0, i % 600], i / 60)
        slots.follow(f"x{i}", bodies[1, 0], i / 60)
        slots.announce(f"x{i}", SKELETON)
    sizes = [len(slots._newcomers), len(slots._ids), len(slots._former), len(slots._skeletons)]
    assert max(sizes) <= 256


def a_crowd(count, spread):
    """Return the poses of people side by side, (count, J, 3) metres, whose sizes differ by a share in all."""
    body = np.cumsum(np.random.default_rng(1).normal(0, 0.2, (len(SKELETON), 3)), axis=0)
    sizes = 1 + spread * (np.arange(count) / count - 0.5)
    return body * sizes[:, None, None] + np.arange(count)[:, None, None] * [3.0, 0, 0]


def all_at_once(slots, poses, first, name, frames):
    """Show people under ids that begin with a name, from a time (s) on; return the slots in the last frame."""
    for k in range(len(poses)):
        slots.announce(f"{name}{k}", SKELETON)
    for i in range(frames):
        found = slots.decide(first + i / 30, [(f"{name}{k}", pose) for k, pose in enumerate(poses)])
    return found


class TooManyCallsError(Exception):
    pass


@pytest.fixture
def at_most():
    """Return a function: calls another one, which may call so many functions of Python."""

    def run(most, work):
        left = most

        def count(_frame, event, _argument):
            nonlocal left
            left -= event == "call"
            if left < 0:
                raise TooManyCallsError

        sys.setprofile(count)
        try:
            return work()
        finally:
            sys.setprofile(None)

    return run


@pytest.mark.parametrize(("people", "back"), [(16, 5), (64, 5), (64, 64)])
def test_a_frame_in_which_many_come_back_costs_little(at_most, people, back):
    slots = Slots(people)
    crowd = a_crowd(people, 0.02)
    assert all_at_once(slots, crowd, 0.0, "a", 5) == [f"p{k + 1}" for k in range(people)]
    at_most(150_000, lambda: all_at_once(slots, crowd[:back] + np.array([1.5, 0, 0]), 10.0, "b", 1))


def test_the_same_goes_for_many_who_were_lost_a_moment_ago(at_most):
    slots = Slots(64)
    crowd = a_crowd(64, 0.02)
    all_at_once(slots, crowd, 0.0, "a", 5)
    at_most(150_000, lambda: all_at_once(slots, crowd[::-1] + np.array([0.3, 0, 0]), 1.0, "b", 1))


def test_eight_people_who_come_back_at_once_get_the_slots_of_before():
    slots = Slots(8)
    crowd = a_crowd(8, 0.8)
    all_at_once(slots, crowd, 0.0, "a", 60)
    order = [3, 0, 7, 5, 1, 2, 6, 4]
    assert all_at_once(slots, crowd[order] + np.array([9.0, 0, 2.0]), 12.0, "b", 70) == [
        f"p{k + 1}" for k in order
    ]
