"""Trials and sessions: recordings cut into parts in their own formats, and one table for a study."""

import csv
import json

import numpy as np
import pytest

from checks.fuzz.recordings import trc
from checks.readme_commands.files import walking
from mossar_adapters.files import read
from mossar_adapters.files.c3d_events import C3dEvent, read_events, write_events
from mossar_adapters.files.c3d_parameters import read_parameters
from mossar_adapters.files.trials import write_c3d_trial


def test_a_c3d_file_is_cut_into_c3d_files_that_are_the_recording_again(mossar, tmp_path):
    walk, clips = tmp_path / "walk.c3d", tmp_path / "clips"
    walk.write_bytes(walking())
    write_events(walk, tmp_path / "events.c3d", [C3dEvent("Foot Strike", 1.5, "Left", 1)])
    status, _, err = mossar("segment", tmp_path / "events.c3d", "--level", "posture", "--cut", clips)
    assert status == 0, err
    parts = [read(path) for path in sorted(clips.glob("*.c3d"))]
    assert len(parts) > 1
    whole = read(walk)
    np.testing.assert_array_equal(np.concatenate([part.positions for part in parts]), whole.positions)
    np.testing.assert_allclose(np.concatenate([part.times for part in parts]), whole.times, atol=1e-9)
    assert read_events(max(clips.glob("*.c3d")))[0].time == pytest.approx(1.5)


def test_trials_of_real_files_are_what_other_libraries_read_of_the_whole(tmp_path):
    from pathlib import Path

    ezc3d = pytest.importorskip("ezc3d")
    source = Path(__file__).parents[3] / "shared" / "data" / "formats" / "c3d" / "gait_13_events.c3d"
    if not source.exists():
        pytest.skip(f"the recording is not here ({source})")
    write_c3d_trial(source, tmp_path / "trial.c3d", 100, 180)
    whole, trial = ezc3d.c3d(str(source)), ezc3d.c3d(str(tmp_path / "trial.c3d"))
    points, analogs = (whole["data"][kind] for kind in ("points", "analogs"))
    np.testing.assert_array_equal(trial["data"]["points"], points[:, :, 100:180])
    np.testing.assert_array_equal(trial["data"]["analogs"], analogs[:, :, 1000:1800])
    assert trial["header"]["points"]["first_frame"] == whole["header"]["points"]["first_frame"] + 100
    old, new = read_parameters(source)[2], read_parameters(tmp_path / "trial.c3d")[2]
    changed = {name for name in old if not np.array_equal(np.asarray(old[name]), np.asarray(new[name]))}
    assert changed <= {"POINT:FRAMES", "TRIAL:ACTUAL_START_FIELD", "TRIAL:ACTUAL_END_FIELD"}
    times = read(tmp_path / "trial.c3d").times
    assert times[0] == pytest.approx(read(source).times[100])


def test_a_trc_file_is_cut_into_trc_files(mossar, tmp_path):
    take, clips = tmp_path / "take.trc", tmp_path / "clips"
    take.write_bytes(trc(120))
    assert mossar("segment", take, "--level", "posture", "--cut", clips)[0] == 0
    parts = [read(path) for path in sorted(clips.glob("*.trc"))]
    whole = read(take)
    np.testing.assert_array_equal(np.concatenate([part.positions for part in parts]), whole.positions)
    assert [note for part in parts for note in getattr(part, "notes", ())] == []


@pytest.mark.parametrize("suffix", ["c3d", "trc"])
def test_a_part_of_a_file_is_cut_out_of_that_part(mossar, tmp_path, suffix):
    take, clips = tmp_path / f"take.{suffix}", tmp_path / "clips"
    take.write_bytes(walking() if suffix == "c3d" else trc(120))
    whole = read(take)
    begin, until = whole.times[20], whole.times[60]
    part = ("--from", str(begin - 1e-4), "--until", str(until + 1e-4))
    status, _, err = mossar("segment", take, "--level", "posture", "--cut", clips, *part)
    assert status == 0, err
    parts = [read(path) for path in sorted(clips.glob(f"*.{suffix}"))]
    positions = np.concatenate([part.positions for part in parts])
    np.testing.assert_array_equal(positions, whole.positions[20:61])


def test_repetitions_are_cut_and_named_after_what_they_are(mossar, tmp_path):
    from mossar_adapters.demo import performance

    whole = performance(2, moves=["rest", *["squat"] * 4, "rest"])
    path, clips = tmp_path / "squats.npz", tmp_path / "trials"
    skeleton = whole.skeleton
    names, parents = np.array(skeleton.names), np.array(skeleton.parents)
    np.savez(
        path, positions=whole.frames.positions, times=whole.frames.times, joint_names=names, parents=parents
    )
    status, _, err = mossar("segment", path, "--repetitions", "--cut", clips, "--of", "repetitions")
    assert status == 0, err
    rows = list(csv.DictReader((clips / "clips.csv").read_text().splitlines()))
    assert len(rows) > 2
    assert rows[1]["clip"].startswith("squats-0002-body_")
    for row in rows:
        clip = read(clips / row["clip"])
        assert clip.times[0] == pytest.approx(float(row["start"]), abs=0.03)
        assert clip.times[-1] == pytest.approx(float(row["end"]), abs=0.03)
    assert mossar("segment", path, "--cut", tmp_path / "b", "--of", "repetitions")[0] == 2
    assert mossar("segment", path, "--cut", tmp_path / "b", "--of", "moves")[0] == 2
    assert mossar("segment", path, "--repetitions", "--of", "repetitions")[0] == 2


def test_moves_are_cut_and_named_after_what_they_are(mossar, tmp_path):
    moves, clips = tmp_path / "moves.json", tmp_path / "punches"
    shown, take = (
        f"demo:?moves={moves}&seed=4"
        for moves in ("rest:2,punch_left,rest:2", "rest:1,kick_right,rest:1,punch_left,rest:2")
    )
    assert mossar("teach", moves, shown, "--name", "jab/../x", "--times", 1)[0] == 0
    assert mossar("record", take, tmp_path / "take.msk", "--seconds", 12)[0] == 0
    status, _, err = mossar(
        "segment", tmp_path / "take.msk", "--moves", moves, "--cut", clips, "--of", "moves"
    )
    assert status == 0, err
    rows = list(csv.DictReader((clips / "clips.csv").read_text().splitlines()))
    assert rows
    assert {path.name for path in clips.iterdir()} == {"clips.csv", *(row["clip"] for row in rows)}
    for row in rows:
        assert row["name"] == "jab/../x"
        assert row["clip"].startswith("take-000")
        assert row["clip"].endswith("-jab_.._x.npz")
        clip = read(clips / row["clip"])
        assert clip.times[0] == pytest.approx(float(row["start"]), abs=0.03)
        assert clip.times[-1] == pytest.approx(float(row["end"]), abs=0.03)


def test_columns_come_from_the_names_of_files_and_make_one_table(mossar, swing, tmp_path):
    for name in ("ann_1_walk", "ann_2_walk", "bo_1_punch_low"):
        (tmp_path / f"{name}.npz").write_bytes(swing.read_bytes())
    takes = sorted(path for path in tmp_path.glob("*.npz") if path.name != "swing.npz")
    table = tmp_path / "study.csv"
    pattern = "{person}_{session}_{trial}"
    status, _, err = mossar("segment", *takes, "--pattern", pattern, "--csv", table)
    assert status == 0, err
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert list(rows[0])[:5] == ["recording", "person", "session", "trial", "performer"]
    found = {(row["person"], row["session"], row["trial"]) for row in rows}
    assert found == {("ann", "1", "walk"), ("ann", "2", "walk"), ("bo", "1", "punch_low")}
    _, out, _ = mossar("segment", takes[0], "--pattern", pattern, "--person", "Ann B.", "--json")
    assert (json.loads(out)["person"], json.loads(out)["session"]) == ("Ann B.", "1")


def test_folders_may_be_part_of_a_pattern(mossar, swing, tmp_path):
    (tmp_path / "ann").mkdir()
    (tmp_path / "ann" / "s2.npz").write_bytes(swing.read_bytes())
    _, out, _ = mossar("segment", tmp_path / "ann" / "s2.npz", "--pattern", "{person}/s{session}", "--json")
    assert (json.loads(out)["person"], json.loads(out)["session"]) == ("ann", "2")


@pytest.mark.parametrize(
    ("pattern", "problem"),
    [
        ("walk", "name each column once"),
        ("{a}_{a}", "name each column once"),
        ("{performer}", "is a column already"),
        ("{2}", "no name for one"),
        ("{a}_{b}", "does not fit"),
    ],
)
def test_patterns_that_cannot_be_are_refused(mossar, swing, pattern, problem):
    status, _, err = mossar("segment", swing, "--pattern", pattern)
    assert (status, problem in err) == (2, True), err
