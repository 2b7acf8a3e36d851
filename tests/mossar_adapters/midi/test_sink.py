"""MIDI: what is sent is read by mido, and the clock keeps the tempo."""

import os
import time

import pytest

from mossar_adapters.address import parse_url
from mossar_adapters.midi.sink import MidiSink
from mossar_adapters.source import Meta
from mossar_adapters.urls import open_sink
from mossar_stream import (
    Event,
    FollowEvent,
    KeyFrameEvent,
    MossarError,
    PoseEvent,
    RepetitionEvent,
    Skeleton,
    StreamEvent,
)

mido = pytest.importorskip("mido")


@pytest.fixture
def key_frame(made):
    return lambda kind="onset", **fields: made(KeyFrameEvent, kind=kind, **fields)


@pytest.fixture
def repetition(made):
    return lambda period, performer="p1": made(RepetitionEvent, period=period, performer=performer)


def messages(path) -> list:
    """Return what mido makes of the bytes in a file."""
    return list(mido.parse_all(path.read_bytes()))


def played(tmp_path, events: list[Event], seconds=0.0, query="") -> list:
    path = tmp_path / "midi.bin"
    sink = MidiSink(parse_url(f"midi:{path}{query}"))
    sink.announce(Meta("p1", Skeleton(("a", "b"), (-1, 0))))
    sink.send(events)
    time.sleep(seconds)
    sink.close()
    sink.close()
    return messages(path)


def test_key_frames_are_notes_that_end(tmp_path, key_frame):
    kinds = ("onset", "minimum", "offset")
    found = played(tmp_path, [*map(key_frame, kinds), key_frame(status="candidate")], 0.2)
    notes = {"note_on": [m.note for m in found if m.type == "note_on"]}
    notes["note_off"] = [m.note for m in found if m.type == "note_off"]
    assert notes == {"note_on": [60, 64, 67], "note_off": [60, 64, 67]}


def test_notes_that_sound_when_it_ends_are_ended(tmp_path, key_frame):
    found = played(tmp_path, [key_frame("offset")], query="?notes=1,2,3")
    assert [(m.type, m.note) for m in found] == [("note_on", 3), ("note_off", 3)]


def test_each_performer_has_a_channel(tmp_path, key_frame):
    found = played(tmp_path, [key_frame(performer=f"p{n}") for n in (1, 2, 1)])
    assert [m.channel for m in found if m.type == "note_on"] == [0, 1, 0]


@pytest.mark.parametrize(("query", "beats"), [("", 1), ("?beats=2", 2)])
def test_the_clock_has_24_pulses_a_cycle(tmp_path, query, beats, repetition):
    found = played(tmp_path, [repetition(None), repetition(0.5)], 1.0, query)
    assert [m.type for m in found if m.type != "clock"] == ["start", "stop"]
    assert sum(m.type == "clock" for m in found) == pytest.approx(48 * beats, abs=3)


def test_the_clock_stops_with_the_repetitions(tmp_path, repetition):
    found = played(tmp_path, [repetition(0.1)], 0.6)
    assert sum(m.type == "clock" for m in found) == pytest.approx(60, abs=2)
    assert found[-1].type == "stop"


def test_the_clock_stops_with_the_take_of_whom_it_follows(tmp_path, repetition):
    ended = [StreamEvent(performer=name, event="ended", take=0) for name in ("p2", "p1")]
    found = played(tmp_path, [repetition(0.2), *ended, repetition(0.2, "p2")], 0.1)
    assert [m.type for m in found if m.type != "clock"] == ["start", "stop", "start", "stop"]


def test_one_performer_keeps_the_clock(tmp_path, repetition):
    found = played(tmp_path, [repetition(9.0, "p2"), repetition(0.1)], 0.2)
    assert sum(m.type == "clock" for m in found) == 1


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_gets_the_bytes(tmp_path, key_frame):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(MossarError, match="nobody reads it"):
        open_sink(f"midi:{path}")
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    sink = open_sink(f"midi:{path}")
    sink.send([key_frame()])
    sink.close()
    found = mido.parse_all(os.read(reader, 100))
    os.close(reader)
    assert [m.type for m in found] == ["note_on", "note_off"]


def test_a_virtual_port_is_found_by_other_programs(key_frame):
    rtmidi = pytest.importorskip("rtmidi")
    try:
        sink = MidiSink(parse_url("midi:?name=mossar-test"))
        name = next(name for name in mido.get_input_names() if "mossar-test" in name)
    except (MossarError, StopIteration, rtmidi.RtMidiError) as error:
        pytest.skip(f"this system has no virtual MIDI ports: {error}")
    with mido.open_input(name) as port:
        sink.send([key_frame()])
        message = port.receive()
    sink.close()
    assert (message.type, message.note) == ("note_on", 60)


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("?notes=1,2", "three numbers"),
        ("?notes=1,2,200", "three numbers"),
        ("?beats=0", "beats"),
        ("?x=1", "'x'"),
    ],
)
def test_wrong_options_are_refused(tmp_path, query, said):
    with pytest.raises(MossarError, match=said):
        open_sink(f"midi:{tmp_path / 'midi.bin'}{query}")


def test_a_file_is_not_replaced_and_a_mid_file_is_refused(tmp_path, key_frame):
    (tmp_path / "midi.bin").write_bytes(b"mine")
    with pytest.raises(MossarError, match="there is a file"):
        open_sink(f"midi:{tmp_path / 'midi.bin'}").send([key_frame()])
    with pytest.raises(MossarError, match=r"\.mid"):
        open_sink(f"midi:{tmp_path / 'take.mid'}")


def test_a_followed_move_turns_a_controller_and_plays_a_note_as_loud_as_its_score_when_it_is_done(
    tmp_path, made
):
    other = {"name": "punch", "progress": 1.0}
    told = [
        made(FollowEvent),
        made(FollowEvent, **other),
        made(FollowEvent, status="done", progress=1.0, count=3, score=0.5),
        made(FollowEvent, **other, status="left"),
    ]
    heard = played(tmp_path, told)
    turned = [(m.control, m.value) for m in heard if m.type == "control_change"]
    assert turned == [(20, 64), (21, 127), (20, 0), (21, 0)]
    assert [(m.note, m.velocity) for m in heard if m.type == "note_on"] == [(72, 64)]
    assert [m.note for m in heard if m.type == "note_off"] == [72]


def pose_event(name, status, performer="p1"):
    said = {"performer": performer, "id": f"{performer}/pose/0/1", "rev": 2, "name": name, "status": status}
    numbers = {"take": 0, "start": 12.0, "seconds": 1.0, "deviation": 4.0, "decided_time": 13.0}
    return PoseEvent(**said, **numbers, limbs={"trunk": 5.0}, joint="Hips")


def test_a_held_pose_sounds_until_it_is_left_and_no_longer_than_the_sink(tmp_path):
    told = [
        pose_event("plank", "entered"),
        pose_event("plank", "held"),
        pose_event("plank", "left"),
        pose_event("tree", "entered"),
        pose_event("tree", "left"),  # never held: no note
        pose_event("tree", "held"),
        pose_event("tree", "held", "p2"),
    ]
    heard = played(tmp_path, told)
    notes = [(m.type, m.channel, m.note) for m in heard]
    assert notes[:2] == [("note_on", 0, 84), ("note_off", 0, 84)]
    assert notes[2:4] == [("note_on", 0, 85), ("note_on", 1, 85)]
    assert sorted(notes[4:]) == [("note_off", 0, 85), ("note_off", 1, 85)]
