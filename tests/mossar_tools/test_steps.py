"""Steps on the command line: in tables, events, exports, and refused where they cannot be."""

import csv
import json

import numpy as np
import pytest

from checks.gaits import GAITS, performed
from checks.readme_commands.files import walking
from mossar_adapters.annotations.reading import read_annotations
from mossar_adapters.files import read
from mossar_adapters.files.c3d_events import read_events


@pytest.fixture
def walk(tmp_path):
    path = tmp_path / "walk.c3d"
    path.write_bytes(walking())
    return path


def test_a_walk_is_told_step_by_step_in_every_output(mossar, walk, tmp_path):
    table, copy = tmp_path / "steps.csv", tmp_path / "copy.c3d"
    status, out, err = mossar("segment", walk, "--steps", "--json", "--csv", table, "--export", copy)
    assert status == 0, err
    found = json.loads(out)
    _, _, truth = performed(GAITS["walking"], 12.0, 60.0)
    assert len(found["steps"]) == len(truth)
    assert found["gait"]["cadence"] == pytest.approx(109, abs=4)
    rows = [row for row in csv.DictReader(table.read_text().splitlines()) if row["state"] == "step"]
    assert len(rows) == found["gait"]["steps"] == len(truth) / 2
    assert {row["channel"] for row in rows} == {"left_foot", "right_foot"}
    assert float(rows[3]["stance"]) + float(rows[3]["swing"]) == pytest.approx(1.1, abs=0.05)
    tiers = {tier.name: tier for tier in read_annotations(copy)}
    assert len(tiers["steps"].marks) == len(truth)
    assert {event.label for event in read_events(copy)} >= {"Foot Strike", "Foot Off"}
    (again,) = [tier for tier in read_annotations(table) if tier.name == "steps"]
    assert again.moments
    events = [(event["time"], f"{event['side']} {event['status']}") for event in found["steps"]]
    known = [
        mark
        for k, mark in enumerate(events)
        if any(mark[1].split()[0] + " strike" == e[1] for e in events[: k + 1])
    ]
    # From each foot's first strike.
    assert [mark.label for mark in again.marks] == [label for _, label in known]
    assert [mark.start for mark in again.marks] == pytest.approx([time for time, _ in known], abs=2e-4)
    _, shown, _ = mossar("segment", walk, "--steps")
    assert "steps, 10" in shown
    assert "stance: left" in shown


def test_a_stream_reports_the_steps_of_the_recording(mossar, events, walk):
    live = [event for event in events("run", walk, "--steps", "--emit", "step") if event["type"] == "step"]
    _, out, _ = mossar("segment", walk, "--steps", "--json")
    whole = json.loads(out)["steps"]
    assert [event["time"] for event in live] == pytest.approx([event["time"] for event in whole], abs=1e-6)
    assert all(event["decided_time"] >= event["time"] for event in live)


def test_steps_of_a_stream_become_a_tier(mossar, walk, tmp_path):
    assert mossar("run", walk, "--steps", "--to", tmp_path / "walk.txt")[0] == 0
    tiers = {tier.name: tier for tier in read_annotations(tmp_path / "walk.txt")}
    assert tiers["steps"].moments
    assert len(tiers["steps"].marks) > 10


def test_feet_are_named_where_they_are_not_known(mossar, tmp_path):
    positions, times, truth = performed(GAITS["walking"], 8.0, 60.0)
    path = tmp_path / "odd.npz"
    names = np.array([f"m{n}" for n in range(8)])
    np.savez(path, positions=positions, times=times, joint_names=names, parents=np.full(8, -1))
    status, _, err = mossar("segment", path, "--steps")
    assert (status, "--feet" in err) == (2, True)
    status, out, _ = mossar("segment", path, "--steps", "--feet", "left=m2,m3,m4", "right=m5,m6,m7", "--json")
    assert status == 0
    assert len(json.loads(out)["steps"]) == len(truth)
    assert mossar("segment", path, "--steps", "--feet", "left=m2", "right=toe")[0] == 2
    assert mossar("segment", path, "--steps", "--feet", "left=m2", "left=m3")[0] == 2


def test_steps_exported_to_any_two_programs_agree(mossar, walk, tmp_path):
    files = [tmp_path / f"steps.{suffix}" for suffix in ("eaf", "TextGrid", "txt", "tsv", "json", "c3d")]
    assert (
        mossar("segment", walk, "--steps", *(word for path in files for word in ("--export", path)))[0] == 0
    )
    for path in files[1:]:
        status, out, err = mossar("agree", files[0], path, "--tier", "steps", "--json")
        assert status == 0, err
        (pair,) = json.loads(out)["pairs"]
        assert pair["all"]["f1_0.05"] == 1.0
        assert abs(pair["all"]["offset_median"]) < 0.001


def test_a_performer_without_feet_is_refused_in_one_line(mossar, tmp_path):
    path = tmp_path / "hands.npz"
    positions = np.random.default_rng(1).normal(size=(60, 2, 3))
    np.savez(path, positions=positions, fps=30.0, joint_names=["hip", "hand"], parents=[-1, 0])
    status, out, err = mossar("run", path, "--steps", "--emit", "step")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "p1 cannot be followed: steps need ankles or toes on both sides; --feet" in err


def test_emitting_steps_needs_the_option(mossar, walk):
    status, _, err = mossar("run", walk, "--emit", "step")
    assert status == 2
    assert "--steps" in err


def test_the_events_of_a_gait_laboratory_are_met():
    from pathlib import Path

    path = Path(__file__).parents[3] / "shared" / "data" / "formats" / "c3d" / "gait_13_events.c3d"
    if not path.exists():
        pytest.skip(f"the recording is not here ({path})")
    whole = read(path)
    found = whole.segment(curves=False, steps=True).steps
    (tier,) = read_annotations(path)
    limits = {"strike": 0.05, "off": 0.07}
    for mark in tier.marks:
        side, _, status = mark.label.partition(" ")
        time = whole.times[0] + mark.start
        near = [abs(e.time - time) for e in found if (e.side, e.status) == (side, status)]
        if 0.2 < mark.start < whole.times[-1] - whole.times[0] - 0.2:
            assert min(near) <= limits[status]
