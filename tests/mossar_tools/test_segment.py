import csv
import itertools
import json
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from checks.fuzz.recordings import c3d
from checks.reference.algorithms import generate_key_frames
from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.files import open_recording
from mossar_adapters.segment_csv import COLUMNS
from mossar_stream import Settings, segment_recording
from mossar_tools.batch import AHEAD, segment_all
from mossar_tools.commands.segment import Options
from mossar_tools.loaded_recording import load_recording

DATA = Path(__file__).parents[3] / "shared" / "data" / "labelled"
needs_data = pytest.mark.skipif(not DATA.exists(), reason=f"no labelled recordings at {DATA}")


def test_json_holds_all_key_frames_and_the_segments_of_the_level(mossar, swing):
    status, out, _ = mossar("segment", swing, "--json", "--level", "0.5")
    report = json.loads(out)
    assert status == 0
    assert list(report) == ["v", "recording", "fps", "level", "key_frames", "segments"]
    assert (report["v"], report["fps"], report["level"]) == (1, 30.0, 0.5)
    recording = open_recording(swing)
    positions = np.concatenate([chunk.positions for chunk in recording.chunks()])
    settings = Settings(level=0.5, range="file")
    expected = segment_recording(positions, 30, recording.skeleton, settings)
    assert [key["frame"] for key in report["key_frames"]] == [key.frame for key in expected.key_frames]
    assert [s["end_frame"] for s in report["segments"]] == [s.end_frame for s in expected.segments]


def test_csv_has_a_row_for_each_segment(mossar, swing):
    # With rests kept, the jump at which the hand stops would be a segment without joints: an outlier, held.
    _, out, _ = mossar("segment", swing, "--csv", "--rests", "merge")
    rows = list(csv.DictReader(out.splitlines()))
    assert tuple(rows[0]) == COLUMNS
    assert {(row["recording"], row["performer"]) for row in rows} == {(str(swing), "p1")}
    assert all(int(a["end_frame"]) == int(b["start_frame"]) for a, b in itertools.pairwise(rows))
    assert {row["kind"] for row in rows[:-1]} <= {"onset", "offset", "minimum"}
    assert all(row["active_joints"] for row in rows if row["state"] == "moving")
    assert float(rows[0]["start"]) == 0.0
    assert all(a["end"] == b["start"] for a, b in itertools.pairwise(rows))
    assert rows[-1]["strength"] == ""


@pytest.mark.parametrize("keep", [0, 1, 3, 1000])
def test_keep_keeps_the_strongest(mossar, swing, keep):
    report = json.loads(mossar("segment", swing, "--json", "--keep", keep)[1])
    assert len(report["segments"]) == min(keep, len(report["key_frames"])) + 1
    assert report["level"] is None


def test_without_an_option_a_table_comes(mossar, swing):
    status, out, _ = mossar("segment", swing)
    assert status == 0
    assert out.startswith("swing.npz · 240 frames, 8.0 s at 30 Hz · 4 joints\n")
    assert "the end" in out.splitlines()[-1]


@pytest.mark.parametrize("output", [("--csv", "t.csv"), ("--json", "t.json"), ("--plot", "t.png")])
def test_the_table_is_swallowed_by_quiet_only(mossar, swing, tmp_path, monkeypatch, output):
    monkeypatch.chdir(tmp_path)
    table = mossar("segment", swing)[1]
    assert mossar("segment", swing, *output)[1] == table
    assert mossar("segment", swing, *output, "--force", "--quiet")[1] == ""
    assert mossar("segment", swing, "--quiet")[1] == ""


@pytest.mark.parametrize("columns", [30, 46, 60, 80])
def test_the_table_fits_the_terminal(mossar, swing, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = mossar("segment", swing, "--repetitions", "--level", "posture")[1].splitlines()
    assert max(map(len, lines)) <= columns
    assert any(" the end" in line for line in lines) == (columns >= 80)
    assert any("moving" in line for line in lines)


def test_answers_come_before_the_segments(mossar, raises):
    lines = mossar("segment", raises, "--repetitions")[1].splitlines()
    (answer,) = (number for number, line in enumerate(lines) if line.startswith("6 repetitions"))
    (table,) = (number for number, line in enumerate(lines) if " segments, divided by" in line)
    assert answer < table


def test_poses_are_among_the_answers(mossar, tmp_path):
    moves = tmp_path / "moves.json"
    part = ("--from", "0", "--until", "1")
    assert mossar("teach", moves, "demo:?moves=rest:2", "--pose", "ease", "--hold", "0.8", *part)[0] == 0
    take = "demo:?moves=rest:4,punch_left,rest:4"
    found = json.loads(mossar("segment", take, "--moves", moves, "--json")[1])["poses"]
    out = mossar("segment", take, "--moves", moves)[1]
    assert found
    assert f"ease: taken {len(found)} time" in out
    assert f"for {found[0]['seconds']:.1f} s, {found[0]['deviation']:.0f}° off, most at " in out


def test_times_of_a_computers_clock_count_from_the_start(mossar, swing):
    with np.load(swing) as archive:
        known = {name: archive[name] for name in archive.files if name != "fps"}
    np.savez(swing, **known, times=2190.0 + np.arange(240) / 30)
    out = mossar("segment", swing)[1]
    assert "times count from the start, which is 2190.000 s of the recording's clock" in out
    assert "2197" not in out
    assert " 7.97 s" in out.splitlines()[-1]
    assert json.loads(mossar("segment", swing, "--json")[1])["segments"][0]["start_time"] == 2190.0


def test_the_built_in_performer_can_be_segmented(mossar):
    report = json.loads(mossar("segment", "demo:?seconds=10", "--json")[1])
    assert report["fps"] == 60
    assert report["segments"][-1]["end_frame"] == 599


@pytest.mark.parametrize(("ending", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_plots_are_pictures(mossar, tmp_path, ending, magic):
    path = tmp_path / f"take.{ending}"
    status, out, err = mossar("segment", "demo:?seconds=10", "--plot", path, "--keep", "4", "--dark")
    assert status == 0
    assert "5 segments, divided by the 4 strongest of " in out
    assert f"drawn: {path}" in err
    assert path.read_bytes().startswith(magic)


def test_a_plot_has_the_size_of_a_page(mossar, tmp_path):
    path = tmp_path / "take.png"
    mossar("segment", "demo:?seconds=10", "--plot", path)
    assert struct.unpack(">II", path.read_bytes()[16:24]) == (1760, 1056)


def test_a_plot_that_cannot_be_written_is_status_2(mossar, tmp_path):
    status, _, err = mossar("segment", "demo:?seconds=5", "--plot", tmp_path / "no" / "take.png")
    assert status == 2
    assert "there is no folder" in err


def test_files_are_written_and_not_replaced_unless_that_is_wished(mossar, swing, tmp_path):
    table, report = tmp_path / "take.csv", tmp_path / "take.json"
    status, out, err = mossar("segment", swing, "--csv", table, "--json", report, "--quiet")
    assert (status, out) == (0, "")
    assert err.splitlines() == [f"written: {report}", f"written: {table}"]
    assert len(list(csv.DictReader(table.read_text().splitlines()))) == len(
        json.loads(report.read_text())["segments"]
    )
    before = table.read_bytes()
    status, _, err = mossar("segment", swing, "--csv", table, "--level", "posture")
    assert (status, table.read_bytes()) == (2, before)
    assert "--force replaces it" in err
    assert mossar("segment", swing, "--csv", table, "--level", "posture", "--force")[0] == 0
    assert table.read_bytes() != before


@needs_data
def test_the_papers_preset_gives_the_key_frames_of_the_papers_equations(mossar):
    path = DATA / "86_01.amc"
    run = (
        "segment",
        path,
        "--preset",
        "paper",
        "--level",
        "posture",
        "--json",
    )
    report = json.loads(mossar(*run)[1])
    positions = np.concatenate([chunk.positions for chunk in open_recording(path).chunks()]).astype(float)
    localised = positions - positions[:, :1]
    steps = np.linalg.norm(np.diff(localised, axis=0, prepend=localised[:1]), axis=2).sum(axis=1)
    travelled = np.cumsum(steps)
    # Equation 1: one second at 120 Hz.
    velocity = travelled - np.concatenate([np.zeros(120), travelled[:-120]])
    expected = generate_key_frames(velocity / velocity.max(), 0.01)
    frames = [key["frame"] for key in report["key_frames"]]
    # The documented difference: early confirmation may add one key frame whose maximum never came, at the end.
    assert frames[: len(expected.key_frames)] == expected.key_frames
    assert len(frames) - len(expected.key_frames) <= 1
    assert [key["kind"] for key in report["key_frames"]][: len(frames) - 1] == expected.kinds[
        : len(frames) - 1
    ]


def test_flat_poses_are_refused_unless_they_are_allowed(mossar, tmp_path):
    pose = [value for joint in range(25) for value in (joint * 0.5, joint * 1.0, 1)]
    path = tmp_path / "flat.json"
    path.write_text(json.dumps({"people": [{"pose_keypoints_2d": pose}]}))
    status, _, err = mossar("segment", path, "--json")
    assert status == 2
    assert "--allow-2d" in err
    status, out, _ = mossar("segment", path, "--json", "--allow-2d", "--fps", "50")
    assert (status, json.loads(out)["fps"]) == (0, 50.0)


def test_the_built_in_performer_takes_joints_root_and_performer(mossar):
    joints = ("--joints", "Hips,LeftHand,RightHand", "--root", "Hips")
    report = json.loads(
        mossar("segment", "demo:?seconds=5&performers=2", *joints, "--performer", "p2", "--json")[1]
    )
    assert {name for part in report["segments"] for name in part["active_joints"]} <= {
        "Hips",
        "LeftHand",
        "RightHand",
    }
    other = json.loads(mossar("segment", "demo:?seconds=5", *joints, "--json")[1])
    assert other["key_frames"] != report["key_frames"]
    for wrong, said in (
        (("--joints", "x"), "no joint called 'x'"),
        (("--performer", "zzz"), "no performer called 'zzz'"),
    ):
        status, _, err = mossar("segment", "demo:", *wrong)
        assert status == 2
        assert said in err


def test_several_recordings_become_one_table_and_a_bad_one_stops_nothing(
    mossar, swing, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for number in range(6):
        Path(f"take{number}.npz").write_bytes(swing.read_bytes())
    Path("take3.npz").write_bytes(b"no recording")
    status, out, err = mossar("segment", "take*.npz", "--csv", "all.csv", "--json", "all.jsonl", "--quiet")
    assert (status, out) == (2, "")
    assert "take3.npz: " in err
    assert "1 of 6 recordings could not be segmented" in err
    rows = list(csv.DictReader(Path("all.csv").read_text().splitlines()))
    names = [f"take{number}.npz" for number in (0, 1, 2, 4, 5)]
    assert list(dict.fromkeys(row["recording"] for row in rows)) == names
    reports = [json.loads(line) for line in Path("all.jsonl").read_text().splitlines()]
    assert [report["recording"] for report in reports] == names
    single = json.loads(mossar("segment", "take0.npz", "--json")[1])
    assert reports[0] == single
    assert len(rows) == 5 * len(single["segments"])
    status, out, _ = mossar("segment", "take0.npz", "take1.npz")
    assert (status, len(out.splitlines())) == (0, 2)


def test_each_of_many_recordings_is_segmented_once_and_in_order(swing, tmp_path, monkeypatch):
    files = []
    for number in range(3 * AHEAD):
        files.append(str(tmp_path / f"{number}.npz"))
        (tmp_path / f"{number}.npz").write_bytes(swing.read_bytes())
    files.insert(2 * AHEAD, str(tmp_path / "there_is_none.npz"))
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    done = list(segment_all(files, Options()))
    assert [one.name for one in done] == files
    assert [one.name for one in done if one.error] == [str(tmp_path / "there_is_none.npz")]


def test_a_process_that_dies_costs_its_recording_only(swing, tmp_path, monkeypatch):
    if os.cpu_count() == 1:
        pytest.skip("one core: there are no processes to die")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    (tmp_path / "sitecustomize.py").write_text(DIES)
    files = [str(tmp_path / f"{name}.npz") for name in ("a", "b", "deadly", "c", "d", "e")]
    for name in files:
        Path(name).write_bytes(swing.read_bytes())
    done = list(segment_all(files, Options()))
    assert [Path(own.name).stem for own in done] == ["a", "b", "deadly", "c", "d", "e"]
    assert [bool(own.error) for own in done] == [False, False, True, False, False, False]
    assert "died" in done[2].error


DIES = """
import os, zipfile
before = zipfile.ZipFile.__init__
def deadly(self, file, *arguments, **options):
    if "deadly" in str(getattr(file, "name", file)):
        os._exit(9)
    before(self, file, *arguments, **options)
zipfile.ZipFile.__init__ = deadly
"""


def test_what_a_stream_ends_with_is_what_annotators_get_of_a_recording(mossar, tmp_path):
    pytest.importorskip("pympi")
    whole, streamed = tmp_path / "whole.TextGrid", tmp_path / "streamed.TextGrid"
    assert mossar("segment", "demo:?seed=3&seconds=12", "--export", whole)[0] == 0
    assert mossar("run", "demo:?seed=3&seconds=12", "--speed", "max", "--to", streamed)[0] == 0
    own = {tier.name: tier for tier in read_annotations(streamed)}
    assert set(own) == {"segments motion", "key frames"}
    marks = own["segments motion"].marks
    assert [mark.start for mark in marks[1:]] == [mark.end for mark in marks[:-1]]
    assert (marks[0].start, marks[-1].end) == (0.0, pytest.approx(12, abs=0.05))
    offline = {tier.name: tier for tier in read_annotations(whole)}
    assert set(offline) == {"segments motion", "segments posture", "segments cluster", "key frames"}
    assert len(offline["segments posture"].marks) > len(offline["segments cluster"].marks)


def test_all_tiers_of_a_video_that_a_pattern_names_are_smoothed(mossar, swing, tmp_path):
    known = dict(np.load(swing))
    known["positions"] = known["positions"] + np.random.default_rng(1).normal(0, 0.01, (240, 4, 3))
    table, tiers = tmp_path / "marks.txt", []
    for name in ("plain.npz", "video.mp4.pose.npz"):
        np.savez(tmp_path / name, **known)
        for source in (name, name.removesuffix(".npz") + "*"):
            given = ("--unit", "m", "--export", table, "--force")
            assert mossar("segment", tmp_path / source, *given)[0] == 0
            tiers.append(read_annotations(table))
    assert tiers[0] == tiers[1] != tiers[2] == tiers[3]


def test_key_frames_and_repetitions_become_events_of_a_copy(mossar, tmp_path):
    take, copy = tmp_path / "take.c3d", tmp_path / "copy.c3d"
    swing = np.zeros((480, 4, 3))
    swing[:, :, 1] = [1.7, 1.2, 0.8, 0.1]
    swing[:, 3, 0] = 0.5 * np.sin(np.arange(480) / 8) * (np.arange(480) % 240 < 160)
    take.write_bytes(c3d(first=20, positions=swing))
    status, out, err = mossar("segment", take, "--repetitions", "--export", copy, "--json")
    assert status == 0, err
    found = json.loads(out)
    tiers = {tier.name: tier for tier in read_annotations(copy)}
    ends = {round(part["end_time"] - 19 / 60, 3) for part in found["segments"][:-1]}
    assert {round(mark.start, 3) for mark in tiers["key frames"].marks} == ends != set()
    assert {name for name in tiers if name.endswith("repetitions")} == (
        {"repetitions"} if found["repetitions"] else set()
    )
    assert mossar("segment", take, "--export", take, "--force")[0] == 2
    assert mossar("segment", "demo:", "--export", tmp_path / "b.c3d")[0] == 2


def test_each_segment_becomes_a_clip(mossar, swing, tmp_path):
    clips = tmp_path / "clips"
    status, _, err = mossar("segment", swing, "--cut", clips)
    assert (status, err) == (0, f"written: {len(list(clips.glob('*.npz')))} clips in {clips}\n")
    rows = list(csv.DictReader((clips / "clips.csv").read_text().splitlines()))
    positions = np.concatenate([np.load(clips / row["clip"])["positions"] for row in rows])
    np.testing.assert_array_equal(positions, np.load(swing)["positions"])
    status, _, err = mossar("segment", swing, "--cut", clips)
    assert status == 2
    assert "--force" in err


@pytest.fixture
def raises(tmp_path):
    """Return a recording of a hand that goes up and down six times in nine seconds."""
    times = np.arange(330) / 30
    wave = np.where((times > 1) & (times < 10), 0.5 - 0.5 * np.cos(2 * np.pi * (times - 1) / 1.5), 0)
    positions = np.zeros((330, 4, 3), np.float32)
    positions[:, 1:, 1] = (0.3, 0.6, 1.7)
    positions[:, 2, 1] += 0.8 * wave
    positions[:, 2, 0] += 0.3 * wave**2
    path = tmp_path / "raises.npz"
    names = np.array(["hips", "knee", "hand", "head"])
    np.savez(path, positions=positions, fps=30.0, joint_names=names, parents=np.array([-1, 0, 0, 0]))
    return path


def test_repetitions_are_rows_of_the_table_and_of_the_report(mossar, raises, tmp_path):
    report = json.loads(mossar("segment", raises, "--repetitions", "--json")[1])
    assert [event["count"] for event in report["repetitions"]] == [1, 2, 3, 4, 5, 6]
    rows = list(csv.DictReader(mossar("segment", raises, "--repetitions", "--csv")[1].splitlines()))
    counted = [row for row in rows if row["state"] == "repetition"]
    assert tuple(rows[0]) == (*COLUMNS, "count", "total", "period", "tempo", "amplitude")
    assert [row["count"] for row in counted] == ["1", "2", "3", "4", "5", "6"]
    assert [float(row["tempo"]) for row in counted[1:]] == pytest.approx([40] * 5, rel=0.03)
    assert [float(row["duration"]) for row in counted] == pytest.approx([1.5] * 6, abs=0.25)
    assert counted[0]["active_joints"] == "hand"
    assert {row["count"] for row in rows if row["state"] != "repetition"} == {""}
    several = tmp_path / "all.csv"
    assert mossar("segment", raises, raises, "--repetitions", "--csv", several)[0] == 0
    assert list(csv.DictReader(several.read_text().splitlines())) == rows * 2


def test_repetitions_are_told_to_people_and_drawn(mossar, raises, tmp_path):
    out = mossar("segment", raises, "--repetitions")[1]
    assert "6 repetitions, 40" in out
    lines = [line for line in out.splitlines() if " in a row" in line]
    assert [line.split()[0] for line in lines] == ["1", "2", "3", "4", "5", "6"]
    assert all(" from " in line and " s to " in line for line in lines)
    drawn = []
    for options in ((), ("--repetitions",)):
        path = tmp_path / f"{len(options)}.svg"
        assert mossar("segment", raises, "--plot", path, *options)[0] == 0
        drawn.append(sum(path.read_text().count(f">{number}<") for number in range(1, 7)))
    assert drawn[1] >= drawn[0] + 6


def test_moves_are_told_written_and_drawn(mossar, tmp_path):
    moves, picture, labels = (tmp_path / name for name in ("moves.json", "take.svg", "take.txt"))
    shown, take = (
        f"demo:?moves={moves}&seed=4"
        for moves in ("rest:2,punch_left,rest:2", "rest:1,kick_right,rest:1,punch_left,rest:2")
    )
    assert mossar("teach", moves, shown, "--name", "jab", "--times", 1)[0] == 0
    found = json.loads(mossar("segment", take, "--moves", moves, "--json")[1])["moves"]
    assert {move["name"] for move in found} == {"jab"}
    assert f"jab, {found[0]['limb'].replace('_', ' ')}, from" in mossar("segment", take, "--moves", moves)[1]
    given = "segment", take, "--moves", moves, "--plot", picture, "--export", labels
    assert mossar(*given)[0] == 0
    assert picture.read_text().count(">jab<") >= 1
    assert labels.read_text().count("moves: jab") == len(found)
    rows = list(csv.DictReader(mossar("segment", take, "--moves", moves, "--csv")[1].splitlines()))
    assert tuple(rows[0]) == (*COLUMNS, "name", "score")
    named = [row for row in rows if row["state"] == "move"]
    assert [(float(row["start"]), row["name"]) for row in named] == [
        (pytest.approx(move["start"], abs=1e-4), "jab") for move in found
    ]
    assert {row["name"] for row in rows if row["state"] != "move"} == {""}
    status, _, err = mossar("segment", take, "--moves", tmp_path / "none.json")
    assert status == 2
    assert "none.json cannot be read" in err


def test_each_limb_has_a_tier_of_the_export(mossar, tmp_path):
    labels = tmp_path / "take.txt"
    assert mossar("segment", "demo:?seconds=8", "--limbs", "--export", labels)[0] == 0
    limbs = ("left_arm", "right_arm", "left_leg", "right_leg", "trunk")
    assert {f"{limb} segments" for limb in limbs} | {"segments motion"} <= {
        tier.name for tier in read_annotations(labels)
    }


def test_a_part_of_a_recording_is_a_recording_for_all_outputs(mossar, tmp_path):
    """From 10 s until 20 s everything is as of a recording that has those frames only."""
    source, part = "demo:?seed=3&seconds=30&fps=30", ("--from", "10", "--until", "20")
    clips, marks = tmp_path / "clips", tmp_path / "marks.eaf"
    report = json.loads(mossar("segment", source, "--json", *part)[1])
    whole = load_recording(source)
    inside = (whole.times >= 10) & (whole.times <= 20)
    expected = segment_recording(
        whole.positions[inside],
        whole.fps,
        whole.skeleton,
        Settings(range="file"),
        times=whole.times[inside],
    )
    assert [key["time"] for key in report["key_frames"]] == [key.time for key in expected.key_frames]
    assert [key["frame"] for key in report["key_frames"]] == [key.frame for key in expected.key_frames]
    assert 10 <= report["segments"][0]["start_time"] < report["segments"][-1]["end_time"] <= 20

    rows = list(csv.DictReader(mossar("segment", source, "--csv", *part)[1].splitlines()))
    assert [float(row["end"]) for row in rows] == pytest.approx(
        [own["end_time"] for own in report["segments"]], abs=1e-4
    )
    assert "from 10 to 20 s" in mossar("segment", source, *part)[1]
    assert mossar("segment", source, "--export", marks, "--cut", clips, *part)[0] == 0
    # Marks count from where the recording begins, so that they fit its video.
    tier = next(tier for tier in read_annotations(str(marks)) if tier.name == "key frames")
    found = [mark.start for mark in tier.marks]
    assert found == pytest.approx([own["end_time"] for own in report["segments"][:-1]], abs=2e-3)
    frames = [len(np.load(clip)["times"]) for clip in sorted(clips.glob("*.npz"))]
    assert sum(frames) == np.count_nonzero(inside)


def test_reports_and_exports_are_in_order_of_time(mossar, raises, tmp_path):
    """Events of a stream are not: a receiver of files need not sort."""
    marks = tmp_path / "marks.vtt"
    status, out, err = mossar("segment", raises, "--repetitions", "--json", "--export", marks)
    assert status == 0, err
    report = json.loads(out)
    for name, field in (("key_frames", "time"), ("segments", "start_time"), ("repetitions", "start")):
        times = [own[field] for own in report[name]]
        assert len(times) > 3
        assert times == sorted(times)
    for tier in read_annotations(str(marks)):
        starts = [mark.start for mark in tier.marks]
        assert starts == sorted(starts)


@pytest.mark.parametrize("name", ["there_is_none.bvh", "text.mp4", "empty.c3d"])
def test_a_file_that_cannot_be_read_is_named(mossar, tmp_path, name):
    path = tmp_path / name
    if name != "there_is_none.bvh":
        path.write_bytes(b"no motion" * (name == "text.mp4"))
    status, _, err = mossar("segment", path)
    assert status == 2
    assert name in err
