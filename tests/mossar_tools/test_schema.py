"""The JSON Schema of the events: what is printed, shipped and documented is what comes out."""

import json
import re
from pathlib import Path

import msgspec
import pytest
from jsonschema import Draft202012Validator

from mossar_adapters.maps.codec import to_json as to_json_line
from mossar_adapters.maps.frame_maps import map_with_run
from mossar_adapters.maps.states import StateMap
from mossar_adapters.source import Meta
from mossar_stream import Segmenter, Settings, Skeleton, to_json
from mossar_tools.evaluation.takes import load_folder
from mossar_tools.event_schema import event_schema

ROOT = Path(__file__).parents[2]
LABELLED = ROOT.parent / "shared" / "data" / "labelled"


@pytest.fixture(scope="module")
def valid():
    """Return what is wrong with an event, by a schema that allows no further fields."""
    schema = event_schema()
    for definition in schema["$defs"].values():
        definition["additionalProperties"] = False
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    return lambda event: [error.message for error in validator.iter_errors(event)] == []


def test_it_is_printed_and_documented(mossar):
    printed = json.loads(mossar("schema")[1])
    assert printed == event_schema()
    assert json.loads((ROOT / "docs" / "events.schema.json").read_text()) == printed, (
        "mossar schema > docs/events.schema.json"
    )


def test_every_event_of_a_run_fits(events, valid):
    found = events("demo", "--speed", "max", "--seconds", "20", "--stats", "5", "--to", "-")
    assert {event["type"] for event in found} == {"key_frame", "segment", "activity", "stream", "stats"}
    assert {e["status"] for e in found if e["type"] == "key_frame"} >= {
        "candidate",
        "withdrawn",
        "merged",
        "final",
    }
    assert all(valid(event) for event in found)


def test_every_meta_fits(valid):
    skeleton = Skeleton(("hip", "hand"), (-1, 0))
    for meta in (Meta("p1", skeleton), Meta("p2", skeleton, fps=30.0)):
        for more in ({}, {"settings": {"level": "motion"}, "run": "a1"}):
            sent = json.loads(to_json_line(map_with_run(msgspec.structs.replace(meta, **more))))
            assert valid(sent)
            assert not valid({**sent, "type": "mata"})
            assert not valid({name: value for name, value in sent.items() if name != "parents"})


def test_every_state_fits(valid):
    for state in (
        StateMap("p1", 0, True),
        StateMap("p1", 2, False, {"body": "moving"}, {"body": 3}, {"squat": 2}, level="motion", run="a1"),
    ):
        sent = json.loads(to_json_line(state))
        assert valid(sent)
        assert not valid({name: value for name, value in sent.items() if name != "present"})


@pytest.mark.parametrize(
    "change", [{"status": "perhaps"}, {"rev": "1"}, {"more": 1}, {"strength": "x"}, {"type": "segment"}]
)
def test_what_is_no_event_does_not_fit(events, valid, change):
    event = next(e for e in events("demo", "--speed", "max", "--seconds", "5") if e["type"] == "key_frame")
    assert valid(event)
    assert not valid({**event, **change})
    assert not valid({name: value for name, value in event.items() if name != "velocity"})


def test_every_event_of_the_labelled_recordings_fits(valid):
    if not LABELLED.is_dir():
        pytest.skip("no labelled recordings in ../shared/data/labelled")
    takes = [take for take in load_folder(LABELLED) if len(take.times) < 3000][:12]
    for take in takes:
        segmenter = Segmenter(take.skeleton, Settings(level=take.level), take.name.replace("/", "_"))
        found = [*segmenter.push(take.positions, take.times), *segmenter.end_take()]
        assert len(found) > 2
        assert all(valid(json.loads(to_json(event))) for event in found)


def test_the_events_in_the_documentation_fit(valid):
    shown = re.findall(r'^\{".*\}$', (ROOT / "docs" / "events.md").read_text(), re.MULTILINE)
    found = [json.loads(line) for line in shown if '"type":"frame"' not in line]
    assert {event["type"] for event in found} == {
        "meta",
        "state",
        "step",
        "key_frame",
        "segment",
        "activity",
        "move",
        "follow",
        "pose",
        "repetition",
        "phase",
        "stream",
        "stats",
    }
    assert all(valid(event) for event in found)
    text = (ROOT / "README.md").read_text()
    example = re.search(r'\{"type":"key_frame".*?\}', text, re.DOTALL).group()
    assert valid(json.loads(example))


def test_the_event_in_the_readme_comes_out_of_the_demo(events):
    text = (ROOT / "README.md").read_text()
    shown = json.loads(re.search(r'\{"type":"key_frame".*?\}', text, re.DOTALL).group())
    found = [e for e in events("demo", "--speed", "max", "--seconds", "4") if e["type"] == "key_frame"]
    first = found[0]
    numbers = {name for name, value in shown.items() if isinstance(value, float)}
    assert {name: value for name, value in first.items() if name not in numbers} == {
        name: value for name, value in shown.items() if name not in numbers
    }
    assert [first[name] for name in numbers] == pytest.approx([shown[name] for name in numbers], rel=1e-6)
    assert f"started to move at {shown['time']:g} s" in text


def test_every_osc_address_is_in_the_documentation():
    source = (ROOT / "adapters/mossar_adapters/osc/event_sink.py").read_text()
    sent = re.findall(r'[`"](/mossar/[a-z_/]+)[`" ]', source)
    text = (ROOT / "docs" / "events.md").read_text()
    assert len(set(sent)) >= 8
    assert [address for address in sent if f"`{address}`" not in text] == []


def test_every_field_is_explained():
    text = (ROOT / "docs" / "events.md").read_text()
    explained_in_place = {"Settings", "Features", "VarianceFloor"}
    for record, definition in event_schema()["$defs"].items():
        for name in definition["properties"] if record not in explained_in_place else ():
            assert f"`{name}`" in text or f'"{name}"' in text, name
