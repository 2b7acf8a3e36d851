"""Wrong usage: one clear line and status 2; odd recordings: a sensible result."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mossar_stream


def save(path, count, joints, positions=None):
    if positions is None:
        positions = np.cumsum(np.random.default_rng(1).normal(0, 0.02, (count, joints, 3)), axis=0)
    names = np.array([f"j{i}" for i in range(joints)])
    parents = np.arange(-1, joints - 1)
    np.savez(path, positions=positions.astype(np.float32), fps=30, joint_names=names, parents=parents)
    return path


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["dance"], "no command called 'dance'; there are demo, run, segment"),
        (["segmnt"], "no command called 'segmnt' - did you mean segment?; there are"),
        (
            ["run", "demo:", "--qiet"],
            "unrecognized arguments: --qiet - did you mean --quiet? (see mossar run",
        ),
        (["segment", "demo:", "--level=1", "--keeep=3"], "--keeep=3 - did you mean --keep?"),
        (["--bla"], "unrecognized arguments: --bla"),
        (["run"], "which source?"),
        (["run", "--bla"], "unrecognized arguments: --bla (see mossar run --help)"),
        (["run", "missing.bvh"], "missing.bvh: cannot be opened: No such file"),
        (["segment", "missing.bvh"], "missing.bvh: cannot be opened: No such file"),
        (["replay", "missing.bvh", "--to", "-"], "missing.bvh: cannot be opened: No such file"),
        (["record", "missing.bvh", "x.msk"], "missing.bvh: cannot be opened: No such file"),
        (["segment"], "which recording?"),
        (["segment", "--csv", "walk.bvh"], "Name it first: mossar segment walk.bvh --csv"),
        (["segment", "a.bvh", "b.bvh", "--plot", "x.png"], "--plot draws one recording"),
        (["segment", "demo:", "--csv", "no/x.csv"], "there is no folder no"),
        (["run", "demo:", "--performer", "zzz"], "demo:: no performer called 'zzz'; there are p1"),
        (["run", "foo://x"], "there is no scheme foo:"),
        (["run", "osc://127.0.0.1:99999"], "the port must be a number, 0 to 65535"),
        (["run", "demo:?bla=1"], "demo: has no option 'bla'"),
        (["run", "demo:", "--preset", "fast"], "argument --preset: invalid choice: 'fast'"),
        (["run", "demo:", "--set", "foo=1"], "no setting called 'foo'; there are rate_limit"),
        (["run", "demo:", "--set", "window"], "'window' is not of the form name=value"),
        (["run", "demo:", "--set", "window=99"], "setting window is 99.0; it must lie between 0.01 and 10"),
        (["run", "demo:", "--set", "similarity=x"], "it must be one of evidence, likelihood, path_kernel"),
        (["run", "demo:", "--level", "strong"], "it must be posture, motion, cluster or a number"),
        (["run", "demo:", "--level", "nan"], "setting level is nan"),
        (["run", "demo:", "--set", "range=file"], "use mossar segment"),
        (["run", "demo:", "--emit", "keys"], "no events called 'keys'; there are key_frame, segment"),
        (["run", "demo:", "--stats", "0"], "'0' is not a positive number"),
        (["run", "demo:", "--speed", "fast"], "'fast' is neither a positive number nor max"),
        (["run", "osc://127.0.0.1:0", "--speed", "2"], "--speed is for recordings and demo:"),
        (
            ["run", "demo:", "--to", "events.xyz"],
            "events go to .jsonl, segments to .csv, annotations to .eaf",
        ),
        (["run", "demo:", "--to", "no/events.jsonl"], "cannot be written: No such file"),
        (["run", "demo:", "--to", "-", "--to", "-"], "it is an input here, or another output"),
        (["run", "-", "-"], "standard input can be read once only"),
        (["run", "demo:", "--control", "http://x"], "use zmq+bind://127.0.0.1:5560, or osc"),
        (["run", "demo:", "--control", "osc"], "--control osc needs an OSC source"),
        (["run", "demo:", "--quiet", "--verbose"], "--quiet and --verbose cannot be wanted at once"),
        (["run", "demo:", "--config", "no.toml"], "no.toml: cannot be read: No such file"),
        (["demo", "--seed", "x"], "'x' is not a whole number from 0"),
        (["demo", "--noise", "5"], "noise must lie in 0 to 1"),
        (["segment", "osc://127.0.0.1:9"], "this command takes a recording or demo:"),
        (["segment", "demo:", "--plot", "x.gif"], "pictures are .png, .svg, .pdf"),
        (["segment", "demo:", "--json", "--csv"], "--json and --csv cannot both go to standard output"),
        (["segment", "demo:", "--keep", "-1"], "is not a whole number from 0"),
        (["replay", "demo:"], "where to?"),
        (["replay", "osc://127.0.0.1:9", "--to", "-"], "sends recordings and demo:, not live streams"),
        (["replay", "demo:?seconds=1", "--to", "-", "--loop"], "--loop is for recordings"),
        (["record", "demo:", "take.txt"], "recordings are written as .msk"),
        (["adapters", "--check", "missing.bvh"], "missing.bvh: cannot be opened"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(mossar, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    status, out, err = mossar(*arguments)
    assert (status, out) == (2, "")
    assert message in err
    lines = err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("mossar: error: ")


@pytest.mark.parametrize("command", [["run"], ["segment"]])
def test_an_unreadable_recording_is_status_2(mossar, tmp_path, command):
    empty = tmp_path / "empty.bvh"
    empty.touch()
    assert mossar(*command, empty)[0] == 2
    none = save(tmp_path / "none.npz", 0, 3)
    status, _, err = mossar(*command, none)
    assert status == 2
    assert "none.npz: 'positions' has 0 frames" in err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "demo:?seconds=1", "--moves", "PIPE"),
        ("run", "demo:?seconds=1", "--config", "PIPE"),
        ("run", "demo:?seconds=1", "--snapshot", "PIPE"),
        ("segment", "demo:?seconds=1", "--moves", "PIPE"),
        ("teach", "PIPE", "--list"),
        ("teach", "moves.json", "demo:?seconds=1", "--labels", "PIPE.csv"),
        ("teach", "moves.json", "demo:?seconds=1", "--labels", "PIPE.txt"),
        ("tune", "demo:?seconds=1", "--labels", "PIPE.json"),
        ("tune", "demo:?seconds=1", "--labels", "PIPE.txt"),
        ("flink", "PIPE"),
        ("run", "demo:?seconds=1", "--to", "zmq+bind://127.0.0.1:0?key=PIPE"),
    ],
)
def test_a_pipe_in_place_of_a_file_is_refused_instead_of_waited_for(mossar, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    for name in ("PIPE", "PIPE.csv", "PIPE.txt", "PIPE.json"):
        os.mkfifo(name)
    status, _, err = mossar(*arguments)
    assert status == 2
    assert "PIPE" in err
    assert len(err.splitlines()) == 1


def test_times_of_labels_are_finite(mossar, tmp_path):
    for name, content in (
        ("labels.txt", "-inf\tinf\tx\n"),
        ("late.txt", "1\tinf\tx\n"),
        ("none.txt", "nan\t1\tx\n"),
        ("moves.csv", "start,end,name\n-inf,inf,x\n"),
        ("none.csv", "start,end,name\n1,nan,x\n"),
    ):
        labels = tmp_path / name
        labels.write_text(content)
        commands = [("teach", tmp_path / "moves.json", "demo:?seconds=3", "--labels", labels)]
        if labels.suffix == ".txt":
            commands.append(("tune", "demo:?seconds=3", "--labels", labels))
        for command in commands:
            status, _, err = mossar(*command)
            assert status == 2, command
            assert name in err.splitlines()[-1]
    assert not (tmp_path / "moves.json").exists()


def test_limbs_wanted_of_a_single_joint_are_logged_once(mossar, tmp_path):
    one = save(tmp_path / "one.npz", 120, 1)
    for command in (("run", one), ("segment", one, "--json")):
        status, out, err = mossar(*command, "--limbs", "--repetitions")
        assert status == 0, err
        assert err.count("no joint of its skeleton can move against another") == 1
        assert '"channel"' not in out


def test_unknown_joints_are_named(mossar, swing):
    status, _, err = mossar("run", swing, "--joints", "j0,elbow")
    assert status == 2
    assert "no joint called 'elbow'; there are j0, j1, j2, j3" in err


@pytest.mark.parametrize(("count", "joints"), [(1, 5), (2, 2), (200, 2), (200, 1)])
def test_small_recordings_give_a_sensible_result(mossar, events, tmp_path, count, joints):
    path = save(tmp_path / "small.npz", count, joints)
    found = events("run", path)
    assert (found[0]["event"], found[-1]["event"]) == ("started", "ended")
    assert found[-2]["status"] == "final"
    status, out, _ = mossar("segment", path, "--json")
    assert status == 0
    segments = json.loads(out)["segments"]
    assert (segments[0]["start_frame"], segments[-1]["end_frame"]) == (0, count - 1)


@pytest.mark.filterwarnings("ignore:no joint is seen in any frame")
def test_nothing_but_missing_joints_is_one_resting_segment(mossar, tmp_path):
    path = save(tmp_path / "nan.npz", 100, 4, np.full((100, 4, 3), np.nan))
    status, out, _ = mossar("segment", path, "--json")
    report = json.loads(out)
    assert (status, report["key_frames"]) == (0, [])
    assert [segment["state"] for segment in report["segments"]] == ["resting"]
    assert mossar("segment", path)[0] == 0
    assert mossar("segment", path, "--plot", tmp_path / "nan.png")[0] == 0


def test_500_joints_are_segmented(events, tmp_path):
    found = events("run", save(tmp_path / "many.npz", 60, 500), "--emit", "stream")
    assert [event["event"] for event in found] == ["started", "ended"]


def test_help_is_status_0_and_shows_examples(mossar):
    status, out, _ = mossar("--help")
    assert status == 0
    assert "mossar demo" in out
    for command in ("demo", "run", "segment", "replay", "record", "adapters"):
        status, out, _ = mossar(command, "--help")
        assert status == 0
        assert f"  mossar {command}" in out


def test_without_a_command_help_comes(mossar):
    assert mossar() == mossar("--help")
    assert mossar()[0] == 0


@pytest.mark.parametrize("option", ["--version", "-V"])
def test_the_version_is_printed(mossar, option):
    assert mossar(option)[:2] == (0, f"mossar-stream {mossar_stream.__version__}\n")


@pytest.mark.parametrize("command", [["run"], ["segment"], ["replay", "--to", "-"]])
def test_a_link_that_leads_to_itself_is_one_line(mossar, tmp_path, command):
    loop = tmp_path / "loop.bvh"
    loop.symlink_to(loop)
    status, _, err = mossar(*command, loop)
    assert status == 2
    assert "Too many levels of symbolic links" in err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_standard_output_that_has_no_room_is_no_defect():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "mossar_tools", "settings"],
            check=False,
            stdout=full,
            stderr=subprocess.PIPE,
        )
    assert done.returncode == 1
    assert done.stderr == b"mossar: error: standard output cannot be written: No space left on device\n"


def test_a_run_in_which_nobody_can_be_followed_is_wrong_usage(mossar, tmp_path):
    take = save(tmp_path / "take.npz", 60, 3)
    status, out, err = mossar("run", take, "--limbs", "a=nope", "--unit", "m")
    assert (status, out) == (2, "")
    assert "p1 cannot be followed: limb a: no joint called 'nope'" in err
    assert "was not announced" not in err


def test_what_is_left_out_of_a_recording_is_said(mossar, tmp_path):
    nobody = save(tmp_path / "nobody.npz", 60, 3, np.full((60, 3, 3), np.nan))
    status, out, err = mossar("segment", nobody, "--unit", "m")
    assert status == 0
    assert "1 segment, no key frames (level motion):" in out
    assert "no performer: every joint is missing" in err
    late = save(tmp_path / "late.npz", 60, 3)
    with np.load(late) as archive:
        known = dict(archive)
    times = np.arange(60) / 30
    times[30:] -= 0.5
    np.savez(late, **known, times=times)
    status, out, err = mossar("segment", late, "--unit", "m")
    assert status == 0
    assert "15 of 60 frames come out of order and are left out" in err
    assert "60 frames, 1.5 s" in out


def test_a_performance_is_counted_whole(mossar):
    assert "300 frames" in mossar("adapters", "--check", "demo:?seconds=5")[1]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (
            ("--limbs", "hands=LeftHnd,LeftLowerArm"),
            ("limb hands: no joint called 'LeftHnd'; there are ", "did you mean LeftHand?"),
        ),
        (("--joints", "LeftHnd"), ("no joint called 'LeftHnd'; there are ", "did you mean LeftHand?")),
        (("--set", "windw=1"), ("no setting called 'windw' - did you mean window?\n",)),
    ],
)
@pytest.mark.parametrize("command", [("run", "--speed", "max"), ("segment",)], ids=lambda given: given[0])
def test_a_name_that_there_is_not_is_answered_with_the_nearest(mossar, command, wrong, said):
    status, _, err = mossar(command[0], "demo:?seconds=1", *command[1:], *wrong)
    assert status == 2
    assert all(words in err for words in said)


@pytest.mark.parametrize("way", ["option", "--set", "--config"])
def test_a_live_sender_whose_limbs_are_misspelt_is_refused_at_once(mossar, tmp_path, way):
    config = tmp_path / "c.toml"
    config.write_text('limbs = "hands=LeftHnd"\n')
    words = {
        "option": ("--limbs", "hands=LeftHnd"),
        "--set": ("--set", "limbs=hands=LeftHnd"),
        "--config": ("--config", config),
    }
    status, out, err = mossar("run", "demo:", *words[way])
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "limb hands: no joint called 'LeftHnd'; there are " in err
    assert "did you mean LeftHand?" in err


def test_feet_that_are_misspelt_are_answered_with_the_nearest(mossar):
    feet = ("--steps", "--feet", "left=LftFoot", "right=RightFoot")
    for command in (("run", "demo:"), ("segment", "demo:?seconds=1")):
        status, _, err = mossar(*command, *feet)
        assert (status, err.count("\n")) == (2, 1)
        assert "feet: no joint called 'LftFoot'; there are " in err
        assert "did you mean LeftFoot?" in err


def test_a_joint_that_is_misspelt_is_wrong_usage_of_every_command(mossar, tmp_path):
    wrong = ("--joints", "LeftHnd")
    for command in (
        ("record", "demo:?seconds=1", tmp_path / "take.msk"),
        ("replay", "demo:?seconds=1", "--to", tmp_path / "take.jsonl"),
    ):
        status, _, err = mossar(*command, *wrong)
        assert (status, err.count("\n")) == (2, 1), command
        assert "did you mean LeftHand?" in err


def test_libraries_of_the_system_do_not_speak_for_us():
    command = [
        sys.executable,
        "-m",
        "mossar_tools",
        "run",
        "demo:?seconds=1",
        "--speed",
        "max",
        "--to",
        "midi:",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    said = [line for line in done.stderr.splitlines() if not line.startswith("mossar: ")]
    assert said == []
