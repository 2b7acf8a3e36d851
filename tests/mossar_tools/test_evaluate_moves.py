"""Moves on command: sessions are judged as commands say, segmented examples by those of other people."""

import json

import numpy as np
import pytest

from mossar_stream import MossarError, MoveEvent, Moves, Settings
from mossar_tools.evaluation.moves_report import evaluate_moves, is_of_moves
from mossar_tools.evaluation.recognising import judge, summary
from mossar_tools.evaluation.sessions import Session, load_session

from .test_teach import FPS, PERSON, PUNCH, RAISE, reach, shown

ORDER = (PUNCH, RAISE, PUNCH)
# shown() rests for 50 frames.
COMMANDS = [
    [0, 65, "punch_left"],
    [65, 145, "raise_right"],
    [145, 260, "punch_left"],
]


def write_session(folder, name, commands=COMMANDS, **label):
    folder.mkdir(parents=True, exist_ok=True)
    positions = shown(*ORDER).astype(np.float32)
    np.savez(
        folder / f"{name}.npz", positions=positions, fps=FPS, joint_names=PERSON.names, parents=PERSON.parents
    )
    content = {"recording": f"{name}.npz", "commands": commands, "unit": "m", **label}
    (folder / f"{name}.json").write_text(json.dumps(content))


def write_samples(folder, *names):
    folder.mkdir(parents=True, exist_ok=True)
    for k, name in enumerate(names):
        size = 1 + 0.1 * k
        arrays = {f"punch_left_{i}": PUNCH * size for i in (1, 2)} | {
            f"raise_right_{i}": RAISE * size for i in (1, 2)
        }
        np.savez(folder / f"{name}.npz", **arrays)


@pytest.fixture
def folder(tmp_path):
    commands = [[50, 100, "punch_left"], [110, 180, "raise_right"], [185, 260, "punch_left"]]
    write_session(tmp_path / "sessions", "ann", commands)
    write_samples(tmp_path / "samples", "ann", "bob", "eve")
    return tmp_path


def test_sessions_and_samples_are_found_and_scored(folder):
    assert is_of_moves(folder)
    found = evaluate_moves(folder, Settings(), lambda _: None)
    assert [choice.examples for choice in found.choices] == [
        "all, at most two",
        "one, number 1",
        "one, number 2",
    ]
    for choice in found.choices:
        assert (choice.scores.recall, choice.scores.precision, choice.scores.f1) == (1, 1, 1)
        assert (choice.scores.sided, choice.scores.right_side) == (3, 3)
        assert 0 < choice.scores.delays[0] <= choice.scores.delays[1] < 1
    assert (found.people, found.told) == (3, {1: 1.0, 2: 1.0})
    assert found.kinds == (2.0, 2.0, 1.0)


def test_the_command_prints_tables_json_and_rows(mossar, folder):
    status, out, err = mossar("evaluate", folder)
    assert status == 0, err
    assert "1 sessions, " in out
    assert "punch_left                     2          0" in out
    assert "2 of each move            100.0 %" in out
    _, out, _ = mossar("evaluate", folder, "--json", "-")
    assert json.loads(out)["choices"][0]["by_move"]["raise_right"] == {"hit": 1}
    _, out, _ = mossar("evaluate", folder, "--csv", "-")
    assert out.splitlines()[1].startswith('"all, at most two",ann,1.0,1.0,1.0')
    status, _, err = mossar("evaluate", folder, "--plot", folder / "moves.png")
    assert status == 2
    assert "moves" in err
    status, out, _ = mossar("evaluate", folder / "samples")
    assert status == 0
    assert out.startswith("\nsegmented examples of 3 people")


def test_examples_may_be_in_a_file_of_mossar_teach(tmp_path):
    moves = Moves(PERSON)
    moves.add("punch_left", PUNCH, FPS)
    moves.save(tmp_path / "mine.json")
    write_session(tmp_path, "ann", moves="mine.json")
    (choice,) = evaluate_moves(tmp_path, Settings(), lambda _: None).choices
    # Said where nobody asked, and never shown.
    assert choice.outcomes[0].missed == [
        "punch_left",
        "raise_right",
    ]


def event(name, time, limb="left"):
    return MoveEvent(
        performer="p", id="p/move/0/1", rev=1, name=name, status="confirmed", take=0, start=time - 1, end=time,
        score=0.9, limb=limb, decided_time=time,
    )  # fmt: skip


def test_a_second_answer_and_a_wrong_one_are_false_and_bad_tries_do_not_count(tmp_path):
    write_session(
        tmp_path, "ann", [[0, 30, "punch_left"], [30, 130, "punch_left"], [130, 190, "raise_right"]]
    )
    write_samples(tmp_path / "samples", "ann")
    session = load_session(tmp_path / "ann.json")
    assert isinstance(session, Session)
    times = [0.5, 2.0, 2.5, 5.0, 8.0]
    names = ["raise_right", "punch_left", "punch_left", "punch_left", "punch_left"]
    outcome = judge(session, [event(*pair) for pair in zip(names, times, strict=True)])
    assert [hit.move for hit in outcome.hits] == ["punch_left"]
    assert outcome.missed == ["raise_right"]
    assert outcome.false == [("punch_left", "punch_left"), ("raise_right", "punch_left")]
    scores = summary([outcome])
    assert (scores.recall, scores.precision, scores.f1) == (0.5, 1 / 3, 0.4)


@pytest.mark.parametrize(
    ("label", "says"),
    [
        ({"commands": [[0, 10_000, "x"]]}, "there are"),
        ({"commands": [[5, 5, "x"]]}, "from frame 5 to 5"),
        ({"commands": "x"}, "commands"),
        ({"moves": "none.json"}, "cannot be read"),
        ({}, "no examples"),
        ({"recording": "none.npz"}, "none.npz"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_line(mossar, tmp_path, label, says):
    write_session(tmp_path, "ann", **label)
    status, _, err = mossar("evaluate", tmp_path)
    assert status == 2
    assert err.count("\n") == 1
    assert says in err


def test_broken_archives_and_other_joints_are_said(tmp_path):
    write_samples(tmp_path / "samples", "ann", "bob")
    (tmp_path / "samples" / "c.npz").write_bytes(b"rubbish")
    assert evaluate_moves(tmp_path, Settings(), lambda _: None).people == 2
    np.savez(tmp_path / "samples" / "d.npz", punch_left_1=reach(1, (0, 0, 1))[:, :2])
    with pytest.raises(MossarError, match="different joints"):
        evaluate_moves(tmp_path, Settings(), lambda _: None)


def test_strictness_takes_a_folder_of_moves_and_a_share(mossar, folder):
    status, _, err = mossar("evaluate", "demo:", "--strict", "0.9")
    assert status == 2
    assert "moves on command" in err
    assert mossar("evaluate", folder, "--strict", "0.9")[0] == 0
    status, _, err = mossar("evaluate", folder, "--strict", "2")
    assert (status, "from 0 to 1" in err) == (2, True)
