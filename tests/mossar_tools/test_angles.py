"""Range of motion on the command line."""

import csv
import json

import numpy as np
import pytest


@pytest.fixture
def squats(tmp_path):
    """Return the built-in performer's squats as a file."""
    from mossar_adapters.demo import performance

    whole = performance(2, moves=["rest", *["squat"] * 4, "rest"])
    path = tmp_path / "squats.npz"
    skeleton = whole.skeleton
    np.savez(
        path,
        positions=whole.frames.positions,
        times=whole.frames.times,
        joint_names=np.array(skeleton.names),
        parents=np.array(skeleton.parents),
    )
    return path


def test_each_repetition_has_a_row_for_each_angle(mossar, squats, tmp_path):
    table, curves, picture = (tmp_path / name for name in ("a.csv", "c.csv", "c.svg"))
    status, out, err = mossar(
        "segment", squats, "--repetitions", "--angles", "--json", "--csv", table, "--curves", curves
    )
    assert status == 0, err
    found = json.loads(out)
    knees = [own for own in found["angles"] if own["angle"] == "left_knee_flexion"]
    assert len(knees) == len(found["repetitions"]) > 2
    assert all(30 < own["range"] < 150 and own["asymmetry"] < 20 for own in knees[1:-1])
    rows = [row for row in csv.DictReader(table.read_text().splitlines()) if row["state"] == "range"]
    assert len(rows) == len(found["angles"])
    frames = list(csv.DictReader(curves.read_text().splitlines()))
    inside = [
        float(row["left_knee_flexion"])
        for row in frames
        if knees[1]["start"] <= float(row["time"]) <= knees[1]["end"]
    ]
    assert max(inside) == pytest.approx(knees[1]["maximum"], abs=0.5)
    assert mossar("segment", squats, "--repetitions", "--curves", picture)[0] == 0
    assert picture.read_text().startswith("<?xml")
    assert "left knee flexion" in mossar("segment", squats, "--repetitions", "--angles")[1]


def test_angles_without_repetitions_or_joints_are_refused(mossar, squats, swing, tmp_path):
    assert mossar("segment", squats, "--angles")[0] == 2
    status, _, err = mossar("segment", swing, "--curves", tmp_path / "c.csv")
    assert (status, "not known by name" in err) == (2, True)
    assert mossar("segment", squats, "--curves", tmp_path / "c.gif")[0] == 2


def test_the_axis_of_a_still_joint_shows_no_noise(squats, tmp_path, monkeypatch, mossar):
    import mossar_tools.figures

    with np.load(squats) as whole:
        content = dict(whole)
    noise = np.random.default_rng(3).normal(0, 1e-6, content["positions"].shape)
    content["positions"] = content["positions"][:1] + noise
    still = tmp_path / "still.npz"
    np.savez(still, **content)
    drawn = []
    monkeypatch.setattr(mossar_tools.figures, "save", lambda figure, _: drawn.append(figure))
    assert mossar("segment", still, "--repetitions", "--curves", tmp_path / "still.svg")[0] == 0
    limits = [axes.get_ylim() for axes in drawn[0].axes]
    assert all(high - low >= 10 for low, high in limits)
