"""Held poses on the command line: teach --pose, run --emit pose, the table of a stream."""

import csv
import json
from pathlib import Path

import pytest

REACH = "demo:?tempo=0.6&moves=rest:2,wave_left"


@pytest.fixture
def shown(run, tmp_path):
    path = str(tmp_path / "poses.json")
    ran = run("teach", path, REACH, "--pose", "at_ease", "--hold", "0.8", "--from", "0", "--until", "1")
    assert (ran.status, ran.err.strip().splitlines()[-1]) == (
        0,
        f"{path}: 1 taken; 0 examples of 0 moves, 1 pose",
    )
    return path


def test_a_part_of_a_recording_becomes_a_pose_that_is_listed_and_removed(run, shown):
    content = json.loads(Path(shown).read_text())
    assert (content["version"], content["examples"]) == (3, [])
    assert [(pose["name"], pose["hold"]) for pose in content["poses"]] == [("at_ease", 0.8)]
    assert run("teach", shown, "--list").out.split() == ["at_ease", "pose,", "held", "after", "0.8", "s"]
    assert run("teach", shown, "--remove", "at_ease").status == 0
    assert run("teach", shown, "--list").out == ""


def test_a_pose_is_mirrored_and_listed_so(run, shown):
    ran = run("teach", shown, "--pose", "at_ease", "--mirrored")
    assert (ran.status, ran.err.strip()) == (0, "at_ease: mirrored")
    assert json.loads(Path(shown).read_text())["rules"] == {"at_ease": {"mirrored": True}}
    assert run("teach", shown, "--list").out.rstrip().endswith("pose, held after 0.8 s; mirrored")
    ran = run("teach", shown, REACH, "--pose", "reach_left", "--mirrored", "--from", "0", "--until", "1")
    assert (ran.status, set(json.loads(Path(shown).read_text())["rules"])) == (0, {"at_ease", "reach_left"})
    assert run("teach", shown, "--pose", "at_ease", "--again", "2").status == 2


def test_a_stream_reports_the_pose(events, shown):
    found = events("run", REACH, "--speed", "max", "--moves", shown, "--emit", "pose")
    assert {event["type"] for event in found} == {"pose"}
    assert [event["status"] for event in found][:3] == ["entered", "held", "left"]
    assert {event["name"] for event in found} == {"at_ease"}


def test_tables_and_annotations_of_a_stream_have_the_pose(run, shown, tmp_path):
    table, notes = tmp_path / "take.csv", tmp_path / "take.eaf"
    ran = run("run", REACH, "--speed", "max", "--moves", shown, "--to", str(table), "--to", str(notes))
    assert ran.status == 0, ran.err
    with table.open() as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "pose"]
    assert {row["name"] for row in rows} == {"at_ease"}
    assert float(rows[0]["deviation"]) < 20
    assert "at_ease" in notes.read_text()


def test_the_table_and_the_report_of_a_recording_have_the_pose(run, shown, tmp_path):
    table, report = tmp_path / "take.csv", tmp_path / "take.json"
    ran = run("segment", REACH, "--moves", shown, "--csv", str(table), "--json", str(report))
    assert ran.status == 0, ran.err
    with table.open() as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "pose"]
    assert {row["name"] for row in rows} == {"at_ease"}
    assert [pose["name"] for pose in json.loads(report.read_text())["poses"]] == ["at_ease"] * len(rows)


def test_what_is_held_at_the_end_of_a_movement_is_the_pose(run, tmp_path):
    path = str(tmp_path / "live.json")
    ran = run("teach", path, "demo:?moves=rest:1,kick_left,rest:2", "--speed", "max", "--pose", "upright")
    assert ran.status == 0
    assert "upright: pose taken" in ran.err
    assert len(json.loads(Path(path).read_text())["poses"]) == 1


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["--pose", "p", "--name", "n"], "--name cannot be given with --pose"),
        (["--pose", "p", "--strict", "0.8"], "cannot be given with --pose"),
        (["--pose", "p", "--discover"], "--discover cannot be given with --pose"),
        (["--hold", "2"], "--hold is of a pose"),
    ],
)
def test_what_does_not_go_with_a_pose_is_refused(run, tmp_path, given, says):
    ran = run("teach", str(tmp_path / "x.json"), REACH, *given)
    assert ran.status == 2
    assert says in ran.err
