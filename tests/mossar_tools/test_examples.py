"""Every example runs as its first lines say, against a real `mossar run`."""

import ast
import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from checks.run_process import free_port
from mossar_adapters.osc.encode import encode
from mossar_stream import FollowEvent

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
RUN_HERE = {
    "send_poses.py",
    "receive_events.py",
    "receive_osc.py",
    "react_to_moves.py",
    "segment_recording.py",
    "segment_frames.py",
    "change_level.py",
    "coach.py",
}


@pytest.fixture
def example(request):
    """Start an example as a process of its own; it is killed at the end if it still runs."""

    def start(name, *arguments):
        places = [ROOT, ROOT / "adapters", ROOT / "tools"]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
        running = subprocess.Popen(
            [sys.executable, ROOT / "examples" / name, *map(str, arguments)],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        request.addfinalizer(lambda: (running.kill(), running.communicate()))
        return running

    return start


def output(running, patience=120):
    out, err = running.communicate(timeout=patience)
    assert running.returncode == 0, err
    return out


def test_every_example_is_run_here_and_short():
    assert {path.name for path in EXAMPLES} == RUN_HERE
    for path in (ROOT / "examples").rglob("*"):
        # A line of a Pure Data patch is a box or a wire.
        if path.is_file() and path.suffix not in {".md", ".pd"} and "__pycache__" not in path.parts:
            # Clients that read every event by position have a line or two for each.
            most = 80 if path.parent.name == "clients" else 60
            assert len(path.read_text().splitlines()) <= most, path


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_every_example_says_what_it_is(path):
    assert ast.get_docstring(ast.parse(path.read_text()))


def test_frames_can_be_pushed(example):
    said = output(example("segment_frames.py"))
    assert "onset" in said
    assert "final" not in said
    assert ": moving" in said


def test_a_recording_is_segmented(example, swing):
    said = output(example("segment_recording.py", swing))
    assert "key frames of Algorithm 2" in said
    assert " moving " in said


def test_poses_arrive_and_their_events_are_received(example, process):
    frames, events, osc = free_port(), free_port(), free_port(socket.SOCK_DGRAM)
    control = free_port()
    heard, heard_osc = (
        example("receive_events.py", f"tcp://127.0.0.1:{events}"),
        example("receive_osc.py", osc),
    )
    run = process(
        *("run", f"zmq+bind://127.0.0.1:{frames}", "--to", "-", "--seconds", "7"),
        *("--to", f"zmq+bind://127.0.0.1:{events}?encoding=json", "--to", f"osc://127.0.0.1:{osc}"),
        *("--control", f"zmq+bind://127.0.0.1:{control}"),
    )
    asked = output(example("change_level.py", f"tcp://127.0.0.1:{control}"))
    assert "{'set': {'level': 'posture'}} -> {'level': 'posture'}" in asked
    example("send_poses.py", f"tcp://127.0.0.1:{frames}", "20")
    out, err = run.communicate(timeout=120)
    assert run.returncode == 0, err
    found = [json.loads(line) for line in out.splitlines()]
    confirmed = [e for e in found if e["type"] == "key_frame" and e["status"] == "confirmed"]
    assert len(confirmed) > 2
    expected = [f"{event['time']:7.2f} s  p1: {event['kind']}" for event in confirmed]
    assert output(heard).splitlines() == expected
    assert len(output(heard_osc).splitlines()) == len(expected)


def test_the_receiver_of_osc_prints_recognised_moves(example):
    port = free_port(socket.SOCK_DGRAM)
    heard = example("receive_osc.py", port)
    move = encode(
        "/mossar/move", "ssssiffffi", "p1", "confirmed", "punch", "left_arm", 0, 1.5, 2.0, 2.1, 0.8, 1
    )
    ended = encode("/mossar/stream", "sssi", "p1", "ended", "end of stream", 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        while heard.poll() is None:  # it takes a while until it listens
            for message in (move, ended):
                sender.sendto(message, ("127.0.0.1", port))
            time.sleep(0.2)
    assert set(output(heard).splitlines()) == {"   1.50 s  p1: punch (left_arm)"}


def test_a_game_reacts_to_moves_that_were_shown(example, process, mossar, tmp_path):
    moves, port = tmp_path / "moves.json", free_port()
    rng = np.random.default_rng(1)
    reach = np.zeros((150, 2, 3), np.float32)
    reach[60:90, 1, 0] = np.sin(np.pi * (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 30))))
    take = tmp_path / "take.npz"
    positions = (np.tile(reach, (2, 1, 1)) + rng.normal(0, 0.0005, (300, 2, 3))).astype(np.float32)
    np.savez(take, positions=positions, fps=30.0, joint_names=["hip", "hand"], parents=[-1, 0])
    assert mossar("teach", moves, take, "--name", "punch", "--unit", "m")[0] == 0
    game = example("react_to_moves.py", f"tcp://127.0.0.1:{port}")
    run = process(
        *("run", str(take), "--moves", str(moves), "--unit", "m", "--speed", "1", "--emit", "move,stream"),
        *("--to", f"zmq+bind://127.0.0.1:{port}?encoding=json"),
    )
    _, err = run.communicate(timeout=120)
    assert run.returncode == 0, err
    assert output(game).splitlines() == [
        f"punch with the hand: the dragon has {left} left" for left in (2, 1)
    ]


def test_a_coach_counts_and_judges_what_was_shown_once(example, mossar, tmp_path):
    squats, take = "demo:?seed=2&moves=rest:2,squat,squat,squat,squat,rest:2", tmp_path / "squats.msk"
    assert mossar("record", squats, take, "--speed", "max")[0] == 0
    lines = output(example("coach.py", take, "3.4", "4.6")).splitlines()
    assert [line.partition(":")[0] for line in lines] == [str(n) for n in range(1, 9)]
    assert all("well done" in line for line in lines)


def test_the_coach_names_the_body_where_every_limb_was_hidden():
    source = (ROOT / "examples" / "coach.py").read_text().removesuffix("main()\n")
    names: dict[str, object] = {}
    exec(compile(source, "coach.py", "exec"), names)  # the example without its last line
    event = FollowEvent(
        performer="p1", id="p1/follow/0/1", rev=1, name="squat", status="done", take=0, count=1, start=0.0,
        time=1.0, progress=1.0, tempo=1.0, certainty=1.0, deviation=12.0, limbs={}, joint="hips", range={},
        score=0.6, decided_time=1.1,
    )  # fmt: skip
    assert names["said"](event) == "1: mind the body, 12 degrees off, good tempo, score 0.60"
