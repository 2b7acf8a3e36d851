import csv
import json
import socket
import threading
import time

import pytest

from checks.run_process import free_port
from mossar_adapters.files import open_recording
from mossar_adapters.osc.encode import encode
from mossar_tools import streaming
from mossar_tools.cli import main


def test_json_lines_come_in_a_pipe(events):
    found = events("run", "demo:?seconds=5", "--speed", "max")
    assert {event["type"] for event in found} == {"stream", "key_frame", "segment", "activity"}
    assert found[-1] == {
        "type": "stream",
        "v": 1,
        "performer": "p1",
        "event": "ended",
        "take": 0,
        "reason": "end of stream",
    }


def test_only_what_is_asked_for_is_emitted_and_revs_stay(events):
    everything = events("run", "demo:?seconds=8", "--speed", "max")
    finals = events("run", "demo:?seconds=8", "--speed", "max", "--emit", "key_frame.final,stream")
    assert finals == [
        e
        for e in everything
        if e["type"] == "stream" or (e["type"], e.get("status")) == ("key_frame", "final")
    ]


def test_several_sinks_at_once(mossar, tmp_path):
    jsonl, table, frames = (tmp_path / name for name in ("e.jsonl", "s.csv", "f.msk"))
    status, out, _ = mossar(
        "run", "demo:?seconds=8", "--speed", "max", "--to", jsonl, "--to", table, "--to", frames
    )
    assert (status, out) == (0, "")
    written = [json.loads(line) for line in jsonl.read_text().splitlines()]
    finals = [e for e in written if (e["type"], e.get("status")) == ("segment", "final")]
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert [row["state"] for row in rows] == [event["state"] for event in finals]
    strengths = {
        e["id"]: e["strength"] for e in written if e.get("status") == "final" and e["type"] == "key_frame"
    }
    assert [row["strength"] for row in rows[:-1]] == [f"{s:.4f}" for s in strengths.values()]
    assert open_recording(frames).frame_count == 480


@pytest.mark.parametrize("name", ["f.msk", "e.jsonl", "e.csv"])
def test_a_file_is_not_replaced_unless_asked(mossar, tmp_path, name):
    path = tmp_path / name
    path.write_text("dear to somebody")
    run = ("run", "demo:?seconds=1", "--speed", "max", "--to", path)
    status, _, err = mossar(*run)
    assert status == 2
    assert "--force replaces it" in err
    assert path.read_text() == "dear to somebody"
    assert mossar(*run, "--force")[0] == 0


def test_standard_input_gives_the_same_events_as_the_recording(events, mossar, swing, process):
    status, frames, _ = mossar("replay", swing, "--to", "-", "--speed", "max")
    assert status == 0
    running = process("run", "-", "--run-id", "test", stdin=-1)
    out, err = running.communicate(frames.encode(), timeout=60)
    assert running.returncode == 0, err
    assert [json.loads(line) for line in out.splitlines()] == events("run", swing)


def test_standard_input_without_frames_is_an_error(process):
    running = process("run", "-", "--run-id", "test", stdin=-1)
    out, err = running.communicate(b"hello\n", timeout=60)
    assert (running.returncode, out) == (1, b"")
    assert b"standard input: there is no frame in it (line 1: " in err


def test_stats_are_events_and_lines(mossar):
    status, out, err = mossar("run", "demo:?seconds=3", "--speed", "max", "--stats", "100", "--emit", "stats")
    assert status == 0
    stats = json.loads(out)
    assert (stats["type"], stats["frames"]) == ("stats", 180)
    assert "mossar: stats: p1, 180 frames, 60.0 fps, latency" in err


def test_quiet_says_nothing_and_json_logs_are_json(mossar):
    run = ("run", "demo:?seconds=1", "--speed", "max", "--stats", "100", "--emit", "stats")
    assert mossar(*run, "--quiet")[2] == ""
    line = mossar(*run, "--log-json")[2]
    assert json.loads(line)["level"] == "info"


def test_joints_and_root_can_be_chosen(events):
    run = ("run", "demo:?seconds=6", "--speed", "max", "--emit", "segment")
    chosen = {"Hips", "LeftHand", "RightHand"}
    found = events(*run, "--joints", ",".join(chosen))
    assert {name for event in found for name in event["active_joints"]} <= chosen
    assert found != events(*run, "--joints", ",".join(chosen), "--root", "LeftHand")


def test_a_performer_can_be_chosen(events):
    run = ("run", "demo:?seconds=2&performers=3", "--speed", "max")
    assert {event["performer"] for event in events(*run, "--performer", "p2")} == {"p2"}


def test_seconds_limit_the_stream(mossar):
    _, out, _ = mossar("run", "demo:", "--speed", "max", "--seconds", "2", "--stats", "9", "--emit", "stats")
    assert json.loads(out)["frames"] == 120


def test_a_snapshot_lets_a_second_run_begin_anew_after_a_complete_one(events, swing, tmp_path):
    state = tmp_path / "state"
    first = events("run", swing, "--snapshot", state)
    assert events("run", swing, "--snapshot", state) == first


def test_a_damaged_snapshot_is_refused(mossar, swing, tmp_path):
    (tmp_path / "state").write_text("hello")
    status, _, err = mossar("run", swing, "--snapshot", tmp_path / "state")
    assert status == 2
    assert "delete it to start anew" in err


def test_zeromq_in_and_out_gives_the_same_key_frames(events, swing, tmp_path):
    direct = [e["frame"] for e in events("run", swing, "--emit", "confirmed")]
    url = f"ipc://{tmp_path}/pose"
    frames = url.replace("ipc:", "ipc+bind:")
    sender = threading.Thread(
        target=main, args=(["replay", str(swing), "--to", f"{frames}?wait=10", "--speed", "8", "--quiet"],)
    )
    sender.start()
    found = events("run", url, "--seconds", "7.96", "--emit", "confirmed")
    sender.join()
    assert [e["frame"] for e in found] == direct


def test_a_start_that_takes_long_plays_no_old_frames(mossar, monkeypatch):
    port = free_port(socket.SOCK_DGRAM)
    opened = streaming._opened_sinks

    def send(first, count):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.connect(("127.0.0.1", port))
            sender.send(encode("/mossar/meta", "sss", "p1", "hips", "head"))
            for k in range(first, first + count):
                sender.send(encode("/mossar/frame", "sidb", "p1", k, k / 50, bytes(24)))

    def slowly_opened(*arguments):
        send(0, 100)
        time.sleep(streaming._LATE + 0.1)
        threading.Timer(1.0, send, (100, 60)).start()
        return opened(*arguments)

    monkeypatch.setattr(streaming, "_opened_sinks", slowly_opened)
    url = f"osc://127.0.0.1:{port}?profile=mossar"
    status, out, err = mossar("run", url, "--seconds", "1", "--stats", "99", "--emit", "stats")
    assert status == 0
    assert json.loads(out)["frames"] == 50
    assert "100 frames (2.0 s) came before the program was ready" in err
