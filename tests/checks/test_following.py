"""The check of following: it counts repetitions, and a message about what was not done did not come true."""

import sys

import numpy as np
import pytest

from checks import following


def raised(joints, far, seed):
    """Return (60, 22, 3) m: a made-up body whose joints go up and come down again."""
    body = np.random.default_rng(0).uniform(-0.4, 0.4, (22, 3)) + np.linspace(1.6, 0.1, 22)[:, None] * [
        0,
        1,
        0,
    ]
    rng = np.random.default_rng(seed)
    frames = np.repeat(body[None], 60, axis=0) + rng.normal(0, 0.002, (60, 22, 3))
    frames[:, joints] += np.sin(np.linspace(0, np.pi, 60))[:, None, None] ** 2 * np.array([0.3, far, 0.2])
    return frames.astype(np.float32)


def test_the_table_counts_right_repetitions_and_ranks_wrong_ones(tmp_path, monkeypatch, capsys):
    arrays = {}
    for name, joints in (("m01", [8, 9]), ("m02", [19, 20, 21])):
        for k in range(5):
            arrays[f"{name}_right_{k}"] = raised(joints, 0.7, k)
            arrays[f"{name}_wrong_{k}"] = raised([*joints, 12, 13], 0.4, 50 + k)
    np.savez(tmp_path / "s01.npz", **arrays)
    monkeypatch.setattr(sys, "argv", ["checks.following", str(tmp_path)])
    following.main()
    said = capsys.readouterr().out
    assert "takes 2: exact 1.00, within one 1.00" in said
    assert "AUC 1.000; done in other exercises 0.000" in said
    assert "certainty  messages  said  came true" in said


def test_a_folder_is_needed(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["checks.following"])
    with pytest.raises(SystemExit):
        following.main()
    assert "folder" in capsys.readouterr().err
