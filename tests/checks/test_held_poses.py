"""The check of held poses: it finds poses that are held, and counts those that nobody takes."""

import sys

import numpy as np
import pytest

from checks import held_poses
from mossar_adapters.demo import performance
from mossar_tools.console import Console


def test_made_holds_are_found_once_from_all_sides(capsys):
    skeleton = performance(seconds=0.1).skeleton
    assert held_poses.found_ones([skeleton], Console(sys.stdout, sys.stderr)) == 1.0
    said = capsys.readouterr().out
    assert all(f" 21 joints, {name:<10}  9 of 9 held once" in said for name in ("t_pose", "hand_up", "plank"))


def test_what_is_held_in_a_quiet_recording_counts_as_false(capsys):
    take = performance(1, fps=30.0, seconds=5)
    console = Console(sys.stdout, sys.stderr)
    quiet = held_poses.Recorded("precog/a", take.skeleton, take.frames.positions, take.frames.times)
    assert held_poses.false_ones([quiet], console) == 0.0
    frames = held_poses.session(take.skeleton, "t_pose", 1.0, 0)
    times = np.arange(len(frames)) / held_poses.FPS
    noisy = held_poses.Recorded("precog/b", take.skeleton, frames, times)
    assert held_poses.false_ones([quiet, noisy], console) == pytest.approx(600 / (5 + times[-1]), rel=0.02)
    assert "t_pose 1" in capsys.readouterr().out


def test_a_folder_is_needed_and_one_without_labels_is_refused(monkeypatch, capsys, tmp_path):
    for given in ([], [str(tmp_path / "nowhere")]):
        monkeypatch.setattr(sys, "argv", ["checks.held_poses", *given])
        with pytest.raises(SystemExit) as left:
            held_poses.main()
        assert left.value.code == 2
    assert "nowhere" in capsys.readouterr().err
