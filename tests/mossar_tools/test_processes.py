"""What only real processes show: pipes closed early, signals, a killed run that goes on."""

import array
import json
import os
import re
import signal
import subprocess
import sys
import time
import urllib.request

import pytest

if os.name == "posix":
    import fcntl
    import pty
    import termios

POSIX = pytest.mark.skipif(os.name != "posix", reason="signals and terminals of POSIX systems")


def first_line(running):
    return json.loads(running.stdout.readline())


def test_a_closed_standard_output_ends_quietly_with_0(process):
    running = process("run", "demo:", "--speed", "max")
    for _ in range(3):
        first_line(running)
    running.stdout.close()
    assert running.wait(30) == 0
    assert running.stderr.read() == b""


def test_a_demo_whose_reader_leaves_says_nothing(process):
    running = process("demo", "--speed", "max", "--seconds", "3000")
    first_line(running)
    running.stdout.close()
    assert running.wait(30) == 0
    assert running.stderr.read() == b""


@POSIX
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_flushes_and_has_its_status(process, number, status):
    running = process("run", "demo:")
    first_line(running)
    running.send_signal(number)
    out, err = running.communicate(timeout=30)
    assert running.returncode == status
    assert err == b""
    last = [json.loads(line) for line in out.splitlines()][-1]
    assert (last["event"], last["reason"]) == ("ended", "stopped")


@POSIX
def test_a_signal_ends_a_replay_and_a_recording_too(process, tmp_path):
    for arguments in (("replay", "demo:", "--to", "-"), ("record", "demo:", tmp_path / "take.msk")):
        running = process(*arguments)
        if arguments[0] == "replay":
            first_line(running)
        else:
            wait_for((tmp_path / "take.msk").exists)
        running.send_signal(signal.SIGINT)
        running.communicate(timeout=30)
        assert running.returncode == 130


@POSIX
def test_a_reader_that_never_reads_does_not_keep_ctrl_c_from_working(process):
    running = process("run", "demo:", "--speed", "max")
    counts = [0]
    wait_for(lambda: counts.append(waiting_in(running.stdout)) or counts[-1] == counts[-2] > 4000, pause=0.3)
    running.send_signal(signal.SIGINT)
    assert running.wait(30) == 130


@POSIX
def test_a_killed_run_goes_on_from_its_snapshot(process, mossar, tmp_path, swing):
    events, state = tmp_path / "e.jsonl", tmp_path / "state"
    whole = tmp_path / "whole.jsonl"
    assert mossar("run", swing, "--to", whole, "--run-id", "one")[0] == 0
    running = process("run", swing, "--to", events, "--snapshot", state, "--speed", "4", "--run-id", "one")
    wait_for(lambda: events.exists() and events.read_text().count("key_frame") > 3)
    running.send_signal(signal.SIGTERM)
    assert running.wait(30) == 143
    assert len(events.read_text()) < len(whole.read_text())
    assert mossar("run", swing, "--to", events, "--snapshot", state)[0] == 0
    assert events.read_text() == whole.read_text()


@POSIX
def test_a_terminal_shows_key_frames_true_cuts_and_a_summary(process):
    inner, outer = pty.openpty()
    running = process("run", "demo:?seconds=12", "--speed", "max", stdout=outer, stderr=outer)
    os.close(outer)
    text = read_all(inner)
    assert running.wait(30) == 0
    assert "confirmed onset" in text
    assert "final" in text
    assert re.search(r"true cut  rest → \w+ +✓", text)
    assert "true cuts hit: " in text
    assert "key frames: " in text
    assert '"type"' not in text


@POSIX
def test_a_terminal_without_unicode_gets_ascii(process, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    inner, outer = pty.openpty()
    running = process("run", "demo:?seconds=8", "--speed", "max", stdout=outer, stderr=outer)
    os.close(outer)
    text = read_all(inner)
    assert running.wait(30) == 0
    assert text.isascii()
    assert "[#" in text
    assert re.search(r"true cut  rest -> \w+ +hit", text)


def test_a_running_stream_answers_prometheus(process):
    running = process("run", "demo:", "--metrics", "0")
    first_line(running)
    url = re.search(r"http://127\.0\.0\.1:\d+/metrics", running.stderr.readline().decode())[0]
    with urllib.request.urlopen(url, timeout=5) as answer:
        text = answer.read().decode()
    running.send_signal(signal.SIGINT)
    assert running.wait(30) == 130
    assert re.search(r'mossar_frames_total\{performer="p1"\} [1-9]', text)
    assert re.search(r'mossar_latency_seconds\{performer="p1",quantile="0.99"\} 0\.0', text)


def test_help_needs_no_numpy():
    code = "import sys; from mossar_tools.cli import main; main(['--help']); sys.exit('numpy' in sys.modules)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)


def read_all(descriptor):
    parts = []
    while True:
        try:
            data = os.read(descriptor, 65536)
        except OSError:
            break
        if not data:
            break
        parts.append(data)
    os.close(descriptor)
    return b"".join(parts).decode()


def waiting_in(pipe):
    count = array.array("i", [0])
    fcntl.ioctl(pipe, termios.FIONREAD, count)
    return count[0]


def wait_for(condition, seconds=20.0, pause=0.02):
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        time.sleep(pause)
