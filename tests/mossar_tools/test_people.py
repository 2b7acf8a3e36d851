"""`--people`, from the command line to the events."""

import json

import numpy as np
import pytest

from mossar_adapters.demo import DemoSource
from mossar_adapters.demo.body import SKELETON
from mossar_stream import Frames
from mossar_tools.dashboard.people_panel import people_card

FPS = 60


@pytest.fixture(scope="module")
def bodies():
    found = []
    for seed in (1, 2):
        source = DemoSource.from_url(f"demo:?seed={seed}&seconds=15", speed="max")
        motion = np.concatenate([f.positions for f in source.items() if isinstance(f, Frames)])
        found.append((0.9, 1.1)[seed - 1] * motion + np.float32([2 * seed, 0, 3]))
    return np.stack(found)


@pytest.fixture
def written(bodies, tmp_path):
    """Return a function: a recording in which person k has the id `ids(k, i)` in frame i."""

    def write(name, ids, people=2):
        path = tmp_path / name
        names = sorted({ids(k, i) for k in range(people) for i in range(bodies.shape[1])})
        lines = [
            {
                "v": 1,
                "type": "meta",
                "performer": n,
                "names": SKELETON.names,
                "parents": SKELETON.parents,
                "root": SKELETON.root,
                "unit": "m",
                "fps": FPS,
            }
            for n in names
        ]
        lines += [
            {
                "v": 1,
                "type": "frame",
                "performer": ids(k, i),
                "seq": i,
                "t": i / FPS,
                "xyz": bodies[k, i].tolist(),
            }
            for i in range(bodies.shape[1])
            for k in range(people)
        ]
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        return path

    return write


def without_who(found):
    """Return events without what slots change: performer, ids made of it, the reason, and the run's name."""
    kept = []
    for event in found:
        event = {name: value for name, value in event.items() if name not in {"reason", "run"}}
        if "id" in event:
            event["id"] = event["id"].split("/", 1)[1]
        kept.append({**event, "performer": ""})
    return kept


def test_one_person_whose_id_is_not_cut_is_segmented_as_without_slots(events, written):
    path = written("one.jsonl", lambda _k, _i: "p7", people=1)
    plain, slots = events("run", path), events("run", path, "--people", "2")
    assert {event["performer"] for event in slots} == {"p1"}
    assert without_who(slots) == without_who(plain)
    assert [e["reason"] for e in slots if e["type"] == "stream" and e["event"] == "started"] == ["id 7"]


def test_ids_that_are_exchanged_and_cut_give_the_key_frames_of_each_body(events, written):
    straight = events("run", written("a.jsonl", lambda k, _i: ("p1", "p2")[k]))
    mixed = written(
        "b.jsonl",
        lambda k, i: ("p7", "p9")[k] if i < 300 else ("p9", "p7")[k] if i < 500 else ("p9", "p12")[k],
    )
    found = events("run", mixed, "--people", "2")
    for name in ("p1", "p2"):
        assert [e for e in found if e["performer"] == name and e["type"] != "stream"] == [
            e for e in straight if e["performer"] == name and e["type"] != "stream"
        ]


@pytest.mark.parametrize("value", ["0", "65", "many"])
def test_an_impossible_number_of_people_is_wrong_usage(mossar, value):
    status, _, err = mossar("run", "demo:", "--people", value)
    assert status == 2
    assert "nearest or first" in err


def test_a_configuration_file_says_how_many(events, written, tmp_path):
    config = tmp_path / "two.toml"
    config.write_text('people = "first"\nremember = 5\n')
    path = written("two.jsonl", lambda k, _i: ("p4", "p5")[k])
    assert {event["performer"] for event in events("run", path, "--config", config)} == {"p1"}


def test_the_card_of_people_is_safe():
    row = {"slot": "p1", "id": "<b>", "there": False, "pinned": True}
    assert "p1: &lt;b&gt;, away, pinned" in people_card([row])
