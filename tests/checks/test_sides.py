"""Sessions of moves on command, seen from other sides."""

import sys

import numpy as np
import pytest

from checks.sides import ANGLES, main, turned
from mossar_tools.evaluation.sessions import Session

from ..mossar_tools.test_evaluate_moves import ORDER, write_samples, write_session  # noqa: TID252 - the same folder
from ..mossar_tools.test_teach import FPS, PERSON, shown  # noqa: TID252 - the same person


def run(monkeypatch, capsys, folder):
    monkeypatch.setattr(sys, "argv", ["sides", str(folder)])
    return main(), capsys.readouterr()


def test_each_view_has_a_line(monkeypatch, capsys, tmp_path):
    commands = [[50, 100, "punch_left"], [110, 180, "raise_right"], [185, 260, "punch_left"]]
    write_session(tmp_path / "sessions", "ann", commands)
    write_samples(tmp_path / "samples", "ann", "bob", "eve")
    status, said = run(monkeypatch, capsys, tmp_path)
    assert status == 0
    head, *lines = said.out.splitlines()
    assert head.split()[:3] == ["view", "recall", "precision"]
    names = [line[:24].strip() for line in lines]
    assert names[:4] == ["as recorded", *(f"turned by {degrees} degrees" for degrees in (30, 90, 180))]
    assert [line.split()[-1] for line in names if line.startswith("turning")] == ["degrees/s"] * 4
    assert names[-1] == "left shown, mirrored"
    assert lines[0].split()[2:5] == ["1.000"] * 3


def test_a_folder_without_sessions_is_named_in_one_line(monkeypatch, capsys, tmp_path):
    status, said = run(monkeypatch, capsys, tmp_path)
    assert (status, said.err) == (2, "the folder holds no sessions of moves on command\n")


def test_a_turned_session_moves_as_it_did():
    times = np.arange(len(shown(*ORDER))) / FPS
    positions = shown(*ORDER).astype(np.float32)
    session = Session("s", PERSON, FPS, positions, times, [], None)
    for angle in ANGLES.values():
        there = turned(session, angle).positions
        for a, b in ((0, 1), (1, 2)):
            was = np.linalg.norm(positions[:, a] - positions[:, b], axis=1)
            assert np.linalg.norm(there[:, a] - there[:, b], axis=1) == pytest.approx(was, abs=1e-5)
        assert there[..., 1] == pytest.approx(positions[..., 1], abs=1e-4)
    quarter = turned(session, ANGLES["turned by 90 degrees"]).positions
    own = positions - positions[:, :1]
    assert (quarter - quarter[:, :1])[..., 0] == pytest.approx(own[..., 2], abs=1e-5)
