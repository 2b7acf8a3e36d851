import json
import socket
import time
from pathlib import Path

import numpy as np
import pytest
from pythonosc.osc_packet import OscPacket

from mossar_adapters.files import FORMATS, open_recording
from mossar_adapters.urls import SCHEMES


def test_a_replayed_recording_has_the_same_frames_and_times(mossar, swing, tmp_path):
    path = tmp_path / "take.msk"
    assert mossar("replay", swing, "--to", path, "--speed", "max")[0] == 0
    first, second = (list(open_recording(p).chunks()) for p in (swing, path))
    assert np.array_equal(*(np.concatenate([c.positions for c in chunks]) for chunks in (first, second)))
    assert np.allclose(*(np.concatenate([c.times for c in chunks]) for chunks in (first, second)))


def test_replay_keeps_the_pace(mossar, swing, tmp_path):
    start = time.monotonic()
    assert mossar("replay", swing, "--to", tmp_path / "take.jsonl", "--speed", "16")[0] == 0
    assert 0.45 < time.monotonic() - start < 2


def test_record_writes_what_comes_and_refuses_to_replace(mossar, tmp_path):
    path = tmp_path / "take.msk"
    record = ("record", "demo:?performers=2", path, "--speed", "max", "--seconds", "1")
    status, out, _ = mossar(*record)
    assert (status, out) == (0, "")
    recording = open_recording(path)
    assert recording.performers == ("p1", "p2")
    assert recording.fps == 60
    assert mossar(*record)[0] == 2
    assert mossar(*record, "--force")[0] == 0


def test_a_source_that_cannot_be_opened_leaves_no_recording_and_replaces_none(mossar, tmp_path):
    status, _, err = mossar("record", "oak:", tmp_path / "take.msk")
    assert status == 1
    assert ("No OAK camera found" in err) or ("mossar-stream[oak]" in err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["take.msk", "take.jsonl"])
@pytest.mark.parametrize("command", ["record", "replay"])
def test_a_full_disk_is_one_line_and_what_was_written_reads(mossar, small_disk, tmp_path, command, name):
    path = tmp_path / name
    where = (path,) if command == "record" else ("--to", path)
    with small_disk(30_000):
        status, _, err = mossar(command, "demo:?seconds=20", *where, "--speed", "max", "--quiet")
    assert (status, err.count("\n")) == (1, 1)
    assert f"{name}: cannot be written: File too large" in err
    assert open_recording(path).frame_count > 10


def test_a_recording_gives_the_events_of_its_source(events, mossar, swing, tmp_path):
    path = tmp_path / "take.msk"
    mossar("record", swing, path)
    assert events("run", path) == events("run", swing)


def test_osc_replay_sends_rotations_of_recordings_that_have_them(mossar, tmp_path):
    path = tmp_path / "turn.bvh"
    path.write_text(bvh())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5)
        port = receiver.getsockname()[1]
        assert mossar("replay", path, "--to", f"osc://127.0.0.1:{port}?profile=vmc", "--speed", "max")[0] == 0
        messages = [m.message for m in OscPacket(receiver.recv(65536)).messages]
    hips = next(m for m in messages if m.address == "/VMC/Ext/Bone/Pos" and m.params[0] == "Hips")
    assert abs(hips.params[-1]) == pytest.approx(np.cos(np.radians(45)), abs=1e-3)


def bvh():
    """A person who has turned by 90° about the vertical, in cm."""
    lines = [
        "HIERARCHY",
        "ROOT Hips",
        "{",
        "OFFSET 0 0 0",
        "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation",
    ]
    limbs = {
        "Spine": (0, 30, 0),
        "Head": (0, 60, 0),
        "LeftArm": (20, 50, 0),
        "RightArm": (-20, 50, 0),
        "LeftUpLeg": (10, -5, 0),
        "RightUpLeg": (-10, -5, 0),
    }
    for name, offset in limbs.items():
        place = " ".join(map(str, offset))
        lines += [f"JOINT {name}", "{", f"OFFSET {place}", "CHANNELS 3 Zrotation Xrotation Yrotation"]
        lines += ["End Site", "{", f"OFFSET 0 {80 if offset[1] > 0 else -85} 0", "}", "}"]
    frame = " ".join(["0 90 0 0 0 90"] + ["0 0 0"] * len(limbs))
    return "\n".join([*lines, "}", "MOTION", "Frames: 2", "Frame Time: 0.033333", frame, frame, ""])


def test_adapters_lists_everything_and_checks_sources(mossar, swing):
    status, out, _ = mossar("adapters")
    assert status == 0
    for word in ("demo:", "osc://", "zmq://", "ws://", "BVH", "C3D", ".msk", ".TextGrid  ", "annotate"):
        assert word in out
    for row in (*SCHEMES, *FORMATS):
        assert row.extra is None or f"extra {row.extra}" in out or f"[{row.extra}]'" in out
    status, out, _ = mossar("adapters", "--check", swing)
    assert status == 0
    assert "240 frames, 30 Hz, performers p1" in out
    status, out, _ = mossar("adapters", "--check", "demo:?seconds=0.5")
    assert status == 0
    assert "performer p1, 30 frames, 21 joints" in out


def test_checking_a_silent_port_explains_itself(mossar, monkeypatch):
    monkeypatch.setattr("mossar_tools.commands.adapters.LISTEN", 0.2)
    status, out, _ = mossar("adapters", "--check", "osc://127.0.0.1:0")
    assert status == 1
    assert "no datagram came yet; a sender on another device needs osc://0.0.0.0" in out


def test_json_logs_of_replay_are_json(mossar, tmp_path, swing):
    _, _, err = mossar("record", swing, tmp_path / "a.msk", "--log-json")
    assert all(json.loads(line)["level"] == "info" for line in err.splitlines())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full on this system")
@pytest.mark.parametrize("name", ["full.msk", "full.jsonl"])
def test_a_full_disk_is_one_line_and_status_1(mossar, tmp_path, name):
    path = tmp_path / name
    path.symlink_to("/dev/full")
    for command in (["record", "demo:?seconds=1", path], ["replay", "demo:?seconds=1", "--to", path]):
        status, _, err = mossar(*command, "--force", "--speed", "max")
        assert (status, err.count("\n")) == (1, 1)
        assert f"{name}: cannot be written: No space left on device" in err


def test_a_recording_is_not_written_over_while_it_is_read(mossar, tmp_path):
    path = tmp_path / "take.msk"
    mossar("record", "demo:?seconds=1", path, "--speed", "max")
    whole = path.read_bytes()
    again = tmp_path / "." / "take.msk"
    for command in (
        ["record", path, again],
        ["replay", path, "--to", again],
        ["run", path, "--to", f"file:{path}"],
    ):
        status, _, err = mossar(*command, "--force")
        assert status == 2
        assert "nothing can be both" in err
    assert path.read_bytes() == whole
