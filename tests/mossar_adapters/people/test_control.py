from types import SimpleNamespace

import pytest

from mossar_adapters.control.requests import Request, of_people
from mossar_adapters.people import PeopleSource
from mossar_adapters.pipeline.naming import Naming
from mossar_adapters.source import Departure, Meta
from mossar_stream import Frames, SettingsError


@pytest.fixture
def running(tracked, script):
    """A pipeline's source with two people in slots, and how to let more of it pass."""
    items = tracked(lambda k, _i: ("p7", "p9")[k], frames=100)
    source = PeopleSource(script([]), 2)

    def let(first, last):
        return [
            out
            for item in items
            if isinstance(item, Meta) or first <= round(item.times[0] * 60) < last
            for out in source.take(item)
        ]

    let(0, 50)
    return SimpleNamespace(pipeline=run_of(source), let=let)


def run_of(*sources):
    """Return what requests need of a pipeline in which the first two slots of each source were used."""
    naming = Naming([source.name for source in sources])
    for i, _ in enumerate(sources):
        for slot in ("p1", "p2"):
            naming.performer(i, slot)
    return SimpleNamespace(feeds=[SimpleNamespace(source=source) for source in sources], naming=naming)


def ask(running, **request):
    return of_people(running.pipeline, Request(**request))["script"]


def test_who_is_in_which_slot(running):
    assert ask(running, get="people") == [
        {"slot": "p1", "id": "p7", "there": True, "pinned": False},
        {"slot": "p2", "id": "p9", "there": True, "pinned": False},
    ]


def test_people_are_exchanged_and_their_takes_end(running):
    assert [row["id"] for row in ask(running, do="exchange", performers=("p1", "p2"))] == ["p9", "p7"]
    after = running.let(50, 60)
    assert {item.performer for item in after if isinstance(item, Departure)} == {"p1", "p2"}
    frames = [item.performer for item in after if isinstance(item, Frames)]
    assert frames[:2] == ["p2", "p1"]


def test_a_slot_is_pinned_and_no_longer(running):
    assert [row["pinned"] for row in ask(running, do="pin", performer="p2")] == [False, True]
    assert [row["pinned"] for row in ask(running, do="unpin", performer="p2")] == [False, False]


def test_fewer_people_are_followed_and_then_the_first_alone(running):
    ask(running, set={"people": 1, "remember": 5})
    assert {item.performer for item in running.let(50, 70) if isinstance(item, Frames)} == {"p1"}
    ask(running, set={"people": "first"})
    assert {item.performer for item in running.let(70, 100) if isinstance(item, Frames)} == {"p1"}


@pytest.mark.parametrize(
    "request_",
    [
        {"do": "exchange", "performers": ("p1",)},
        {"do": "exchange", "performers": ("p1", "p3")},
        {"do": "pin", "performer": "p5"},
        {"set": {"people": 0}},
        {"set": {"people": "all"}},
        {"set": {"people": 2, "level": "motion"}},
        {"set": {"remember": "long"}},
    ],
)
def test_what_is_impossible_is_refused(running, request_):
    with pytest.raises(SettingsError):
        ask(running, **request_)


@pytest.fixture
def two_sources(tracked, script):
    """A run of two sources with two people each: `p1` and `p2`, and, as events call them, `p3` and `p4`."""
    sources = []
    for name in ("left", "right"):
        source = PeopleSource(script([]), 2)
        source.name = name
        for item in tracked(lambda k, _i: ("p7", "p9")[k], frames=50):
            source.take(item)
        sources.append(source)
    return run_of(*sources)


def ids(run):
    found = of_people(run, Request(get="people"))
    return {row["slot"]: (source, row["id"], row["pinned"]) for source, rows in found.items() for row in rows}


def test_slots_of_two_sources_have_the_names_of_events(two_sources):
    assert ids(two_sources) == {
        "p1": ("left", "p7", False),
        "p2": ("left", "p9", False),
        "p3": ("right", "p7", False),
        "p4": ("right", "p9", False),
    }


def test_one_person_of_two_sources_is_pinned_and_two_are_exchanged(two_sources):
    of_people(two_sources, Request(do="pin", performer="p3"))
    of_people(two_sources, Request(do="exchange", performers=("p3", "p4")))
    assert ids(two_sources) == {
        "p1": ("left", "p7", False),
        "p2": ("left", "p9", False),
        "p3": ("right", "p9", False),
        "p4": ("right", "p7", True),
    }


@pytest.mark.parametrize(
    ("request_", "why"),
    [
        ({"do": "exchange", "performers": ("p1", "p3")}, "p1 and p3 are people of different sources"),
        ({"do": "exchange", "performers": ("p3", "p3")}, "p3 cannot be exchanged with itself"),
        ({"do": "pin", "performer": "p5"}, "no slot 'p5'; there are p1, p2, p3, p4"),
    ],
)
def test_what_two_sources_cannot_do_changes_nothing(two_sources, request_, why):
    before = ids(two_sources)
    with pytest.raises(SettingsError, match=why):
        of_people(two_sources, Request(**request_))
    assert ids(two_sources) == before


def test_without_slots_there_is_nothing_to_ask():
    pipeline = SimpleNamespace(feeds=[SimpleNamespace(source=SimpleNamespace())])
    with pytest.raises(SettingsError, match="--people"):
        of_people(pipeline, Request(get="people"))
