"""`mossar teach`: moves are shown live or from recordings, and `mossar run --moves` recognises them."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import filelock
import numpy as np
import pytest

from mossar_adapters.annotations.tiers import Mark, Tier
from mossar_adapters.annotations.writing import write_annotations
from mossar_stream import Moves, Skeleton
from mossar_tools import moves_file
from mossar_tools.errors import UsageError

FPS = 30.0
PERSON = Skeleton(("hip", "left", "right"), (-1, 0, 0))
RESTING = np.array([[0.0, 1, 0], [-0.3, 1, 0], [0.3, 1, 0]])


def reach(joint, way, count=30):
    there = np.sin(np.pi * (0.5 - 0.5 * np.cos(np.linspace(0, np.pi, count))))[:, None] * np.array(way)
    frames = np.repeat(RESTING[None], count, axis=0)
    frames[:, joint] += there
    return frames


def shown(*performances):
    rest = np.repeat(RESTING[None], 50, axis=0)
    parts = [rest, *(part for one in performances for part in (one, rest))]
    return np.concatenate(parts) + np.random.default_rng(1).normal(0, 0.0005, (sum(map(len, parts)), 3, 3))


PUNCH, RAISE = reach(1, (0, 0.2, 0.9)), reach(2, (0.5, 0.9, 0))


@pytest.fixture
def recording(tmp_path):
    def write(name, positions):
        path = tmp_path / name
        np.savez(
            path,
            positions=positions.astype(np.float32),
            fps=FPS,
            joint_names=PERSON.names,
            parents=PERSON.parents,
        )
        return path

    return write


def test_movements_are_taken_as_they_come_and_recognised_later(mossar, events, recording, tmp_path):
    moves = tmp_path / "moves.json"
    for name, move in (("punch", PUNCH), ("raise", RAISE)):
        take = recording(f"{name}.npz", shown(move, move, move))
        status, _, err = mossar("teach", moves, take, "--name", name, "--unit", "m")
        assert status == 0, err
        assert "example 2 of 2 taken" in err
    assert [Moves.load(moves).names, len(Moves.load(moves))] == [("punch", "raise"), 4]
    played = recording("played.npz", shown(RAISE, PUNCH, PUNCH, RAISE))
    found = events("run", played, "--moves", moves, "--emit", "move.confirmed", "--unit", "m", "--to", "-")
    assert [event["name"] for event in found] == ["raise", "punch", "punch", "raise"]
    assert [event["limb"] for event in found] == ["right", "left", "left", "right"]


def test_a_part_of_a_recording_and_a_table_of_parts(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH, RAISE))
    assert (
        mossar("teach", moves, take, "--name", "punch", "--from", "1.2", "--until", "3", "--unit", "m")[0]
        == 0
    )
    table = tmp_path / "labels.csv"
    table.write_text("start,end,name\n1.2,3,punch\n4,6,raise\n")
    assert mossar("teach", moves, take, "--labels", table, "--unit", "m")[0] == 0
    status, out, _ = mossar("teach", moves, "--list")
    assert status == 0
    assert [line.split()[:2] for line in out.splitlines()] == [["punch", "2"], ["raise", "1"]]
    assert mossar("teach", moves, "--remove", "punch")[0] == 0
    assert Moves.load(moves).names == ("raise",)


def test_times_are_those_of_the_recording_and_annotations_count_from_its_first_frame(
    mossar, recording, tmp_path
):
    take = recording("take.npz", shown(PUNCH))
    with np.load(take) as archive:
        known = dict(archive)
    np.savez(take, **known, times=40.0 + np.arange(len(known["positions"])) / FPS)
    table, marks = tmp_path / "labels.csv", tmp_path / "marks.txt"
    table.write_text("start,end,name\n41.2,43,punch\n")
    write_annotations(marks, [Tier("moves", (Mark(1.2, 3.0, "punch"),))], 7.0)
    found = []
    for k, asked in enumerate(
        (["--labels", table], ["--name", "punch", "--from", "41.2", "--until", "43"], ["--labels", marks])
    ):
        moves = tmp_path / f"{k}.json"
        status, _, err = mossar("teach", moves, take, *asked, "--unit", "m")
        assert status == 0, err
        found.append(Moves.load(moves).examples[0].positions)
    assert found[0] == found[1] == found[2]


def test_a_part_with_a_hidden_joint_is_followed_as_it_was_shown(mossar, tmp_path):
    positions, confidence = shown(PUNCH, PUNCH), np.ones((210, 3), np.float32)
    positions[40:, 2] = 5.0  # the sensor guesses where the hand is that it does not see
    confidence[40:, 2] = 0.0
    take, moves = tmp_path / "take.npz", tmp_path / "moves.json"
    known = {"joint_names": PERSON.names, "parents": PERSON.parents, "fps": FPS}
    np.savez(take, positions=positions.astype(np.float32), confidence=confidence, **known)
    status, _, err = mossar("teach", moves, take, "--name", "punch", "--from", "1.5", "--until", "2.9")
    assert status == 0, err
    (example,) = Moves.load(moves).examples
    placed = example.metres(3) - example.metres(3)[:, :1]
    assert np.allclose(placed[:, 2], RESTING[2] - RESTING[0], atol=5e-3)
    status, out, err = mossar("segment", take, "--moves", moves, "--follow", "punch", "--json")
    assert status == 0, err
    followed = json.loads(out)["followed"]
    assert [one["count"] for one in followed if one["status"] == "done"] == [1, 2]
    assert min(one["score"] for one in followed) > 0.9


def test_a_file_that_holds_no_moves_is_told_of_before_anybody_moves(mossar, tmp_path):
    (tmp_path / "moves.json").write_text("{}")
    status, _, err = mossar("teach", tmp_path / "moves.json", "demo:", "--name", "x")
    assert status == 2
    assert "not a file of moves" in err
    assert "rest, do" not in err


def test_too_few_movements_are_said_and_those_taken_are_kept(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH))
    status, _, err = mossar("teach", moves, take, "--name", "punch", "--times", "3", "--unit", "m")
    assert status == 1
    assert "1 of 3 examples taken" in err
    assert len(Moves.load(moves)) == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--name", "x"], "what to learn from"),
        (["{take}"], "--name"),
        (["{take}", "--name", "a\tb"], "printable"),
        (["{take}", "--name", "x", "--from", "0", "--until", "1"], "nothing moves"),
        (["{take}", "--name", "x", "--from", "100"], "no frames"),
        (["{take}", "--labels", "{none}"], "cannot be read"),
        (["--list"], "cannot be read"),
    ],
)
def test_mistakes_are_one_line(mossar, recording, tmp_path, arguments, says):
    take = recording("take.npz", shown(PUNCH))
    filled = [part.format(take=take, none=tmp_path / "none.csv") for part in arguments]
    status, _, err = mossar(
        "teach", tmp_path / "moves.json", *filled, *(["--unit", "m"] if "{take}" in arguments else [])
    )
    assert status == 2
    assert says in err
    assert len([line for line in err.splitlines() if "error" in line.lower() or says in line]) == 1
    assert not (tmp_path / "moves.json").exists()


def test_a_broken_file_of_moves_is_refused(mossar, recording, tmp_path):
    path = tmp_path / "moves.json"
    path.write_text(json.dumps({"format": "mossar-moves", "version": 9}))
    for command in (["run", recording("take.npz", shown(PUNCH)), "--moves", path], ["teach", path, "--list"]):
        status, _, err = mossar(*command)
        assert status == 2
        assert "version 9" in err


def test_moves_that_do_not_fit_the_stream_are_said(mossar, recording, tmp_path):
    path = tmp_path / "moves.json"
    other = Moves(Skeleton(("hip", "tail"), (-1, 0)))
    other.add("wag", reach(1, (0.5, 0, 0))[:, :2], FPS)
    other.save(path)
    _, _, err = mossar(
        "run", recording("take.npz", shown(PUNCH)), "--moves", path, "--unit", "m", "--to", "-"
    )
    assert "tail" in err


@pytest.mark.parametrize("name", ["all", "left,right"])
def test_a_name_that_follow_could_not_take_is_refused(mossar, recording, tmp_path, name):
    status, _, err = mossar(
        "teach", tmp_path / "moves.json", recording("take.npz", shown(PUNCH)), "--name", name, "--unit", "m"
    )
    assert status == 2
    assert err.splitlines()[-1].endswith(
        f"a move cannot be called {name!r}: --follow takes names with commas between, or all"
    )
    assert not (tmp_path / "moves.json").exists()


@pytest.mark.parametrize("suffix", [".eaf", ".TextGrid", ".txt"])
def test_annotations_name_moves(mossar, recording, tmp_path, suffix):
    if suffix != ".txt":
        pytest.importorskip("pympi")
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH, RAISE))
    tiers = [
        Tier("segments motion", (Mark(0, 1, "resting"),)),
        Tier("moves", (Mark(1.2, 3, "punch"), Mark(4, 6, "raise"))),
    ]
    write_annotations(tmp_path / f"take{suffix}", tiers, 7.0)
    labels = ("--labels", tmp_path / f"take{suffix}", "--unit", "m")
    assert mossar("teach", moves, take, *labels)[0] == 0
    assert Moves.load(moves).names == ("punch", "raise")
    status, _, err = mossar("teach", moves, take, *labels, "--tier", "x")
    assert status == 2
    assert "no tier called x; there are:" in err


def test_moves_that_nobody_named_are_grouped_drawn_and_named(mossar, recording, tmp_path):
    moves, picture = tmp_path / "moves.json", tmp_path / "kinds.svg"
    take = recording("take.npz", shown(PUNCH, RAISE, PUNCH, PUNCH, RAISE))
    discover = ("teach", moves, take, "--discover", "--unit", "m", "--level", "cluster")
    status, out, err = mossar(*discover, "--plot", picture)
    assert status == 0, err
    kinds = [line.split() for line in out.splitlines()]
    assert [kind[:4] for kind in kinds[:2]] == [["kind", "1", "3", "times,"], ["kind", "2", "2", "times,"]]
    assert "3 times" in picture.read_text()
    assert not moves.exists()
    assert mossar(*discover, "--names=-,raise", "--times", "1")[0] == 0
    assert [Moves.load(moves).names, len(Moves.load(moves))] == [("raise",), 1]
    status, _, err = mossar(*discover, "--names", ",".join("abcdefghij"))
    assert status == 2
    assert "kinds of moves" in err
    assert mossar("teach", moves, take, "--names", "a")[0] == 2


def test_ten_thousand_examples_get_one_clear_error(mossar, recording, tmp_path):
    moves, take, table = tmp_path / "moves.json", recording("take.npz", shown(PUNCH)), tmp_path / "labels.csv"
    table.write_text("start,end,name\n" + "1.2,3,punch\n" * 10_000)
    status, _, err = mossar("teach", moves, take, "--labels", table, "--unit", "m")
    assert status == 2
    assert "500 examples already" in err
    assert not moves.exists()


@pytest.mark.parametrize(("how", "status", "saved"), [("SIGINT", 130, 2), ("SIGKILL", -9, 0)])
def test_nothing_is_saved_before_the_series_is_whole_or_the_user_ends_it(
    recording, tmp_path, how, status, saved
):
    if not hasattr(signal, how):
        pytest.skip("no such signal here")
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(*[PUNCH] * 12))
    before = Moves(PERSON)
    before.add("raise", RAISE, FPS)
    before.save(moves)
    command = [sys.executable, "-m", "mossar_tools", "teach", moves, take, "--name", "punch", "--times", "12"]
    with subprocess.Popen(
        [*map(str, command), "--unit", "m", "--speed", "4"], stderr=subprocess.PIPE, text=True
    ) as process:
        said = 0
        for line in process.stderr:
            said += "taken" in line
            if said == 2:
                break
        assert Moves.load(moves).names == ("raise",)
        process.send_signal(getattr(signal, how))
        rest = process.stderr.read()
    assert process.returncode == status
    assert [example.name for example in Moves.load(moves).examples].count("punch") >= saved
    assert ("of punch saved" in rest) == bool(saved)
    assert Moves.load(moves).names[0] == "raise"
    left = {path.name for path in Path(tmp_path).iterdir() if "moves" in path.name}
    assert left <= {"moves.json", ".moves.json.lock"}


def test_an_example_unlike_the_others_is_shown_and_asked_for_again(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH, RAISE, PUNCH))
    status, out, err = mossar("teach", moves, take, "--name", "punch", "--unit", "m")
    assert status == 0
    assert out == ""
    lines = err.splitlines()
    assert next(i for i, line in enumerate(lines) if "punch: not kept" in line) > 0
    assert "punch: example 2 is another movement than the others" in err
    assert "example 2 of 2 taken" in err
    assert sum(any(0x2800 < ord(sign) < 0x2900 for sign in line) or "*" in line for line in lines) >= 9
    assert len(Moves.load(moves)) == 2
    kept = tmp_path / "kept.json"
    status, _, err = mossar("teach", kept, take, "--name", "punch", "--unit", "m", "--keep")
    assert status == 0
    assert "punch: example 2 is another movement than the others" in err
    assert "not kept" not in err
    assert len(Moves.load(kept)) == 2


def test_the_first_is_dropped_if_the_other_two_are_alike(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(RAISE, PUNCH, PUNCH))
    status, _, err = mossar("teach", moves, take, "--name", "punch", "--unit", "m")
    assert status == 0
    assert "the last two are alike and kept; the first is dropped" in err
    only = tmp_path / "only.json"
    assert mossar("teach", only, recording("r.npz", shown(RAISE)), "--name", "raise", "--times", "1")[0] == 0
    assert min(Moves.load(moves).costs(RAISE, FPS)) > 1


def test_the_last_example_is_taken_back(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH, PUNCH))
    assert mossar("teach", moves, take, "--name", "punch", "--unit", "m")[0] == 0
    raised = recording("raised.npz", shown(RAISE))
    assert mossar("teach", moves, raised, "--name", "raise", "--times", "1", "--unit", "m")[0] == 0
    status, _, err = mossar("teach", moves, "--undo", "--name", "punch")
    assert (status, err.splitlines()[0]) == (0, "punch: the last example is taken back; 1 left")
    status, _, err = mossar("teach", moves, "--undo")
    assert (status, err.splitlines()[0]) == (0, "raise: the last example is taken back; 0 left")
    assert mossar("teach", moves, "--undo")[0] == 0
    status, _, err = mossar("teach", moves, "--undo")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "has no example to take back" in err


def test_a_list_draws_each_example(mossar, recording, tmp_path):
    moves, take = tmp_path / "moves.json", recording("take.npz", shown(PUNCH, PUNCH))
    assert mossar("teach", moves, take, "--name", "punch", "--unit", "m")[0] == 0
    status, out, err = mossar("teach", moves, "--list")
    assert status == 0
    assert [line.split()[:2] for line in out.splitlines()] == [["punch", "2"]]
    drawn = [line for line in err.splitlines() if line.strip()]
    assert len(drawn) >= 6
    assert not any(sign.isalnum() for line in drawn for sign in line)


def test_a_fixed_length_is_for_what_has_no_rest(mossar, recording, tmp_path):
    turns = np.concatenate([PUNCH] * 12)
    moves, take = tmp_path / "moves.json", recording("take.npz", turns)
    given = ("--name", "punches", "--times", "1", "--unit", "m")
    status, _, err = mossar("teach", moves, take, *given)
    assert status == 1
    assert "0 of 1 examples taken" in err
    status, _, err = mossar("teach", moves, take, *given, "--seconds", "4")
    assert status == 0, err
    assert err.splitlines()[0] == "do 'punches' for 4 s when it says now; 1 time"
    assert "punches: now, for 4 s" in err
    (example,) = Moves.load(moves).examples
    positions, rate = example.shown(len(PERSON))
    assert (len(positions) - 1) / rate == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (["{take}", "--undo"], "--undo needs no stream"),
        (["--undo", "--list"], "two commands"),
        (["--undo", "--pose", "x"], "--remove takes back a pose"),
        (["--undo"], "cannot be read"),
        (["{take}", "--list"], "--list needs no stream"),
        (["--name", "x", "--seconds", "4"], "--seconds needs a stream"),
        (["--name", "x", "--keep"], "--keep needs a stream"),
        (["{take}", "--name", "x", "--seconds", "4", "--from", "1"], "leave it out with --from"),
        (["{take}", "--name", "x", "--keep", "--labels", "x.csv"], "leave it out with --labels"),
        (["{take}", "--pose", "x", "--seconds", "4"], "leave it out with --pose"),
        (["{take}", "--name", "x", "--seconds", "0.1"], "from 0.5 to 60 s"),
        (["{take}", "--name", "x", "--seconds", "-3"], "--seconds"),
    ],
)
def test_wrong_usage_is_answered_in_one_line(mossar, recording, tmp_path, given, says):
    take = recording("take.npz", shown(PUNCH))
    status, _, err = mossar("teach", tmp_path / "moves.json", *[part.format(take=take) for part in given])
    assert status == 2
    assert says in err.splitlines()[-1]
    assert len([line for line in err.splitlines() if "error" in line.lower()]) == 1


def test_a_place_that_cannot_be_written_is_said_before_the_performer_moves(mossar, recording, tmp_path):
    take = recording("take.npz", shown(PUNCH))
    status, _, err = mossar("teach", tmp_path / "none" / "moves.json", take, "--name", "x")
    assert status == 2
    assert "cannot be written" in err
    assert "rest, do" not in err


TAKE_MANY = """
import sys, time
from pathlib import Path
import numpy as np
from mossar_stream import Skeleton
from mossar_tools.series import Series
from mossar_tools.taking import Movement
_, path, movement, name, ready, go = sys.argv
shown = np.load(movement)
person = Skeleton(("hip", "left", "right"), (-1, 0, 0))
Path(ready).touch()
while not Path(go).exists():
    time.sleep(0.001)
for _ in range(15):
    series = Series(Path(path), person, name, keeps=True)
    series.show(Movement(shown, 30.0, 0.0, 1.0, (0, len(shown) - 1)))
    series.save(Path(path))
"""


def test_two_programs_that_teach_at_once_lose_nothing(tmp_path):
    moves, movement, go = tmp_path / "moves.json", tmp_path / "punch.npy", tmp_path / "go"
    np.save(movement, PUNCH)
    ready = [tmp_path / "one", tmp_path / "other"]
    programs = [
        subprocess.Popen([sys.executable, "-c", TAKE_MANY, *map(str, (moves, movement, path.name, path, go))])
        for path in ready
    ]
    while not all(path.exists() for path in ready):
        assert all(program.poll() is None for program in programs)
        time.sleep(0.01)
    go.touch()
    assert [program.wait(120) for program in programs] == [0, 0]
    names = [example.name for example in Moves.load(moves).examples]
    assert [names.count(path.name) for path in ready] == [15, 15]


def test_a_file_that_another_program_does_not_let_go_is_said(monkeypatch, tmp_path):
    path = tmp_path / "moves.json"
    monkeypatch.setattr(moves_file, "PATIENCE", 0.1)
    with (
        filelock.FileLock(tmp_path / ".moves.json.lock"),
        pytest.raises(UsageError, match="another program"),
        moves_file.changing(path, PERSON),
    ):
        pass
    assert not path.exists()
