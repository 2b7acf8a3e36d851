"""The check of following: it counts repetitions, and a message about what was not done did not come true."""

import json
import sys

import numpy as np
import pytest

from checks import following
from mossar_stream.moves.mirroring import mirrored_joints


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
    assert "committed at 0.9: 1." in said or "committed at 0.9: 0." in said


def save_three_people(folder, count):
    """Save so many right and wrong repetitions of two exercises by each of three people."""
    for person in range(3):
        arrays = {}
        for name, joints in (("m01", [8, 9]), ("m02", [19, 20, 21])):
            for k in range(count):
                arrays[f"{name}_right_{k}"] = raised(joints, 0.7, 10 * person + k)
                arrays[f"{name}_wrong_{k}"] = raised([*joints, 12, 13], 0.4, 50 + 10 * person + k)
        np.savez(folder / f"s0{person}.npz", **arrays)


@pytest.mark.parametrize("whose", ["--foreign", "--others"])
def test_the_examples_may_be_those_of_other_people(tmp_path, monkeypatch, capsys, whose):
    save_three_people(tmp_path, 5)
    shown = []
    once = following.followed
    monkeypatch.setattr(following, "followed", lambda own, all_: shown.append(len(own)) or once(own, all_))
    monkeypatch.setattr(sys, "argv", ["checks.following", str(tmp_path), whose])
    following.main()
    assert set(shown) == {4 if whose == "--others" else 1}
    assert "takes 6: exact 1.00, within one 1.00" in capsys.readouterr().out


def test_of_moves_on_command_the_one_that_is_made_leads(tmp_path, monkeypatch, capsys):
    still = np.repeat(raised([8], 0.0, 0)[:1], 60, axis=0)
    arms, legs = (raised(joints, 0.7, 7) for joints in ([8, 9], [19, 20, 21]))
    positions = np.concatenate([still, arms, still, legs, still, still])
    for folder in ("samples", "sessions"):
        (tmp_path / folder).mkdir()
    shown = {"arms_1": raised([8, 9], 0.7, 1), "legs_1": raised([19, 20, 21], 0.7, 2)}
    np.savez(tmp_path / "samples" / "ann.npz", **shown)
    names, parents = following.SKELETON.names, following.SKELETON.parents
    np.savez(
        tmp_path / "sessions" / "ann.npz", positions=positions, fps=30.0, joint_names=names, parents=parents
    )
    commands = [[0, 60, "arms"], [60, 150, "arms"], [150, 300, "legs"], [300, 360, "arms"]]
    label = {"recording": "ann.npz", "commands": commands, "unit": "m"}
    (tmp_path / "sessions" / "ann.json").write_text(json.dumps(label))
    monkeypatch.setattr(sys, "argv", ["checks.following", "--sessions", str(tmp_path)])
    following.main()
    said = capsys.readouterr().out
    assert "ann: 2 of 3 lead at 0.6, 1 never came so far" in said  # nobody follows the last command
    assert "all 3: 0.667; of those that came so far 1.000" in said


def test_a_folder_is_needed(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["checks.following"])
    with pytest.raises(SystemExit):
        following.main()
    assert "folder" in capsys.readouterr().err


def test_without_options_the_examples_of_others_have_rows_beside_the_own_ones(tmp_path, monkeypatch, capsys):
    save_three_people(tmp_path, 4)
    monkeypatch.setattr(sys, "argv", ["checks.following", str(tmp_path)])
    following.main()
    said = capsys.readouterr().out
    for kind in ("one other", "two each of all others"):
        assert (
            f"followed_by_others, {kind}: exact 1.00 (worst person 1.00), within one 1.00, AUC 1.000" in said
        )
    for kind in ("own example", "one other", "two each of all others"):
        assert f"repeated, {kind}: 0.000 of other exercises done" in said


def test_the_mirror_image_of_another_person_counts():
    shown = [raised([12, 13], 0.7, 1)]  # the other arm
    image = shown[0][:, mirrored_joints(following.SKELETON)] * np.array([-1, 1, 1], np.float32)
    made = [raised([12, 13], 0.7, 2), raised([12, 13], 0.7, 3)]
    done = following.followed([image], made, mirrored=True)
    assert sum(event.status == "done" for event in done) == 2
    assert not any(event.status == "done" for event in following.followed([image], made))


def test_moves_are_recognised_with_the_examples_of_others(tmp_path, monkeypatch, capsys):
    still = np.repeat(raised([8], 0.0, 0)[:1], 60, axis=0)
    names, parents = following.SKELETON.names, following.SKELETON.parents
    for folder in ("samples", "sessions"):
        (tmp_path / folder).mkdir()
    for k, player in enumerate(("ann", "bob")):
        shown = {
            "arms_1": raised([8, 9], 0.7, 10 + k),
            "arms_2": raised([8, 9], 0.7, 20 + k),
            "legs_1": raised([19, 20, 21], 0.7, 30 + k),
            "legs_2": raised([19, 20, 21], 0.7, 40 + k),
        }
        np.savez(tmp_path / "samples" / f"{player}.npz", **shown)
        made = [still, raised([8, 9], 0.7, 50 + k), still, raised([19, 20, 21], 0.7, 60 + k), still, still]
        place = tmp_path / "sessions" / f"{player}.npz"
        np.savez(place, positions=np.concatenate(made), fps=30.0, joint_names=names, parents=parents)
        label = {"recording": place.name, "commands": [[0, 150, "arms"], [150, 360, "legs"]], "unit": "m"}
        place.with_suffix(".json").write_text(json.dumps(label))
    monkeypatch.setattr(sys, "argv", ["checks.following", "--sessions", str(tmp_path)])
    following.main()
    said = capsys.readouterr().out
    row = next(line for line in said.splitlines() if line.startswith("moves_others, 1 player: F1 "))
    assert float(row.rpartition(" ")[2]) > 0.6
    assert "moves_others, 2" not in said  # there is one other
