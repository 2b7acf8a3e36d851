"""`--people`, from the command line to the events."""

import json
import signal
import socket
import time

import numpy as np
import pytest
from pythonosc.osc_message_builder import build_msg

from mossar_adapters.demo import DemoSource
from mossar_adapters.demo.body import SKELETON
from mossar_adapters.files import ReadOptions, open_recording
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_frame_sink
from mossar_stream import Frames, Moves
from mossar_tools.dashboard.people_panel import people_card

from .test_teach import FPS as TAUGHT_FPS
from .test_teach import PERSON, PUNCH, shown

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


def test_remembering_without_people_is_wrong_usage(mossar):
    status, _, err = mossar("run", "demo:", "--remember", "5")
    assert status == 2
    assert "--remember needs --people" in err


def test_a_configuration_file_says_how_many(events, written, tmp_path):
    config = tmp_path / "two.toml"
    config.write_text('people = "first"\nremember = 5\n')
    path = written("two.jsonl", lambda k, _i: ("p4", "p5")[k])
    assert {event["performer"] for event in events("run", path, "--config", config)} == {"p1"}


def test_the_card_of_people_is_safe():
    row = {"slot": "p1", "id": "<b>", "there": False, "pinned": True}
    assert "p1: id &lt;b&gt;, away, pinned" in people_card([row])
    assert "p1: id 7, away" in people_card([{**row, "id": "p7"}])


def mixed(k, i):
    """Ids that are exchanged, and then one of them cut."""
    return ("p7", "p9")[k] if i < 300 else ("p9", "p7")[k] if i < 500 else ("p9", "p12")[k]


def test_a_recording_of_slots_holds_each_body_whole(mossar, written, bodies, tmp_path):
    take = tmp_path / "take.msk"
    status, _, err = mossar("record", written("mixed.jsonl", mixed), take, "--people", "2")
    assert status == 0, err
    assert open_recording(take).performers == ("p1", "p2")
    for k, name in enumerate(("p1", "p2")):
        chunks = open_recording(take, ReadOptions(performer=name)).chunks()
        assert np.allclose(np.concatenate([chunk.positions for chunk in chunks]), bodies[k], atol=1e-6)


def test_a_move_is_taught_by_a_person_whose_id_is_cut_in_the_middle_of_it(mossar, tmp_path):
    positions, cut = shown(PUNCH, PUNCH), 65  # the first punch is from frame 50 to 80

    def written(name, ids):
        path = tmp_path / name
        lines = [
            {
                "v": 1,
                "type": "meta",
                "performer": n,
                "names": PERSON.names,
                "parents": PERSON.parents,
                "unit": "m",
            }
            for n in sorted(set(map(ids, range(len(positions)))))
        ]
        lines += [
            {"v": 1, "type": "frame", "performer": ids(i), "t": i / TAUGHT_FPS, "xyz": pose.tolist()}
            for i, pose in enumerate(positions)
        ]
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
        return path

    straight = written("straight.jsonl", lambda _: "p7")
    torn = written("torn.jsonl", lambda i: "p7" if i < cut else "p8")
    taught = []
    for path, options in ((straight, ()), (torn, ("--people", "1"))):
        moves = tmp_path / f"{path.stem}.json"
        status, _, err = mossar("teach", moves, path, "--name", "punch", *options)
        assert status == 0, err
        taught.append(Moves.load(moves).examples)
    assert len(taught[0]) == 2
    assert [one.positions for one in taught[1]] == [one.positions for one in taught[0]]


def test_a_part_of_a_recording_is_taught_by_the_person_in_a_slot(mossar, written, bodies, tmp_path):
    take = written("mixed.jsonl", mixed)
    for k, name in enumerate(("p1", "p2")):
        moves = tmp_path / f"{name}.json"
        options = ("--people", "2", "--performer", name, "--from", "4", "--until", "6")  # ids change at 5 s
        status, _, err = mossar("teach", moves, take, "--name", "turn", *options)
        assert status == 0, err
        (example,) = Moves.load(moves).examples
        shown = np.array(example.positions).reshape(-1, len(SKELETON), 3)
        assert np.allclose(shown * 1e-4, bodies[k, 240:361], atol=1e-4)  # kept in units of 0.1 mm


def test_the_reason_names_the_id_if_one_slot_is_wanted(events, written):
    found = events("run", written("mixed.jsonl", mixed), "--people", "2", "--performer", "p2")
    assert {e["performer"] for e in found} == {"p2"}
    assert [e["reason"] for e in found if e.get("event") == "started"] == ["id 9"]


def test_a_killed_run_with_slots_goes_on_from_its_snapshot(process, mossar, written, tmp_path):
    take, found, state, whole = (
        written("mixed.jsonl", mixed),
        *map(tmp_path.joinpath, ("e.jsonl", "s", "w.jsonl")),
    )
    options = ("--people", "2", "--run-id", "test")
    assert mossar("run", take, "--to", whole, *options)[0] == 0
    running = process(
        *("run", take, "--to", found, "--snapshot", state, "--snapshot-every", "0.2", "--speed", "4"),
        *options,
    )
    until = time.monotonic() + 60
    while not (found.exists() and found.read_text().count('"p2"') > 12):
        assert time.monotonic() < until
        time.sleep(0.02)
    running.send_signal(signal.SIGTERM)
    assert running.wait(30) == 143
    assert len(found.read_text()) < len(whole.read_text())
    status, _, err = mossar("run", take, "--to", found, "--snapshot", state, *options)
    assert status == 0, err

    def of_each(path):
        events = [json.loads(line) for line in path.read_text().splitlines()]
        return {name: [e for e in events if e["performer"] == name] for name in ("p1", "p2")}

    assert of_each(found) == of_each(whole)


def test_a_third_slot_is_made_over_osc_while_running(process, bodies):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    url = f"osc://127.0.0.1:{port}?profile=mossar"
    running = process("run", url, "--people", "2", "--control", "osc", "--log-level", "info")
    while b"listen" not in (line := running.stderr.readline()) and b"osc" not in line:
        assert line
    sink = open_frame_sink(url)
    asked = build_msg("/mossar/set/people", 3).dgram
    three = (*bodies, bodies[0] + np.float32([-2, 0, 0]))
    for k in range(3):
        sink.announce(Meta(f"x{k}", SKELETON, 60.0))
    for i in range(500):
        if i == 200:
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                sender.sendto(asked, ("127.0.0.1", port))
        for k, body in enumerate(three):
            sink.send_frames(Frames(body[i : i + 1], np.array([i / FPS]), performer=f"x{k}"))
        time.sleep(0.004)
    sink.close()
    time.sleep(1.0)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    started = [
        (event["performer"], event["reason"])
        for event in map(json.loads, out.splitlines())
        if event["type"] == "stream" and event["event"] == "started"
    ]
    assert started[:3] == [("p1", "id x0"), ("p2", "id x1"), ("p3", "id x2")], err.decode()
    assert b"id x2 is refused" in err
