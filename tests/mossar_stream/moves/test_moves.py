"""Moves: examples are checked and cut, files of moves keep them, and nobody's file does harm."""

import json

import numpy as np
import pytest

from mossar_stream import Moves, MovesError, Skeleton

from .conftest import FPS, PERSON, STANDING, performed


def with_rest(name, before=40, after=40):
    still = STANDING[None]
    return np.concatenate(
        [np.repeat(still, before, axis=0), performed(name), np.repeat(still, after, axis=0)]
    )


def frames_of(example):
    return len(example.positions) // (3 * len(PERSON))


def test_an_example_is_cut_at_its_onset_and_offset():
    moves = Moves(PERSON)
    moves.add("punch", with_rest("punch_left"), FPS)
    moves.add("punch", performed("punch_left"), FPS)
    long, short = map(frames_of, moves.examples)
    assert long < 27 + 12
    assert abs(long - short) <= 10  # what smoothing spreads a movement by


def test_a_long_example_keeps_a_bounded_number_of_frames():
    moves = Moves(PERSON)
    moves.add("slow", performed("circle_left", seconds=20.0), FPS)
    assert frames_of(moves.examples[0]) == 128


@pytest.mark.parametrize(
    ("name", "positions", "fps", "says"),
    [
        ("x", STANDING[None], FPS, "8 to"),
        ("x", np.repeat(STANDING[None], 60, axis=0), FPS, "nothing moves"),
        ("x", np.where(np.arange(27)[:, None, None] == 5, np.nan, performed("punch_left")), FPS, "frame 5"),
        ("x", performed("punch_left")[:, :7], FPS, "15 joints"),
        ("x", performed("punch_left") * 1e6, FPS, "metres"),
        ("x", performed("punch_left"), 0.0, "rate"),
        ("x", performed("punch_left"), float("nan"), "rate"),
        ("", performed("punch_left"), FPS, "name"),
        ("a\x1b[31mb", performed("punch_left"), FPS, "name"),
        ("x" * 65, performed("punch_left"), FPS, "name"),
    ],
)
def test_bad_examples_get_one_clear_error(name, positions, fps, says):
    moves = Moves(PERSON)
    with pytest.raises(MovesError, match=says) as caught:
        moves.add(name, positions, fps)
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()
    assert len(moves) == 0


def test_there_is_a_most_of_examples():
    moves = Moves(Skeleton(("hip", "hand"), (-1, 0)))
    wave = np.zeros((12, 2, 3))
    wave[:, 1, 0] = np.sin(np.linspace(0, 3, 12))
    for _ in range(500):
        moves.add("wave", wave, FPS)
    with pytest.raises(MovesError, match="500"):
        moves.add("wave", wave, FPS)


def test_a_file_keeps_everything(moves, tmp_path):
    path = tmp_path / "moves.json"
    moves.save(path)
    again = Moves.load(path)
    assert again.skeleton == moves.skeleton
    assert again.examples == moves.examples
    assert json.loads(path.read_text())["version"] == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["moves.json"]


def test_moves_can_be_forgotten(moves):
    mine = Moves.from_json(moves.to_json())
    mine.remove("punch_left")
    assert "punch_left" not in mine.names
    mine.remove_example(0)
    assert len(mine) == len(moves) - 2
    with pytest.raises(MovesError, match="no move called 'punch_left'"):
        mine.remove("punch_left")


def changed(moves, **fields):
    return json.dumps({**json.loads(moves.to_json()), **fields}).encode()


def test_files_that_are_none_are_refused_in_one_line(moves):
    text = moves.to_json()
    example = json.loads(text)["examples"][0]
    bad = [
        b"",
        b"{",
        b"[" * 100_000,
        b"\xff\xfe",
        text[: len(text) // 2],
        changed(moves, format="other"),
        changed(moves, version=2),
        changed(moves, version=0),
        changed(moves, extra=1),
        changed(moves, skeleton={"names": [], "parents": []}),
        changed(moves, examples=[{**example, "name": "a\nb"}]),
        changed(moves, examples=[{**example, "fps": 0}]),
        changed(moves, examples=[{**example, "positions": example["positions"][:-1]}]),
        changed(moves, examples=[{**example, "positions": [10**12] * 45 * 9}]),
        changed(moves, examples=[{**example, "positions": [0] * 45}]),
        changed(moves, examples=[example] * 501),
    ]
    for content in bad:
        with pytest.raises(MovesError) as caught:
            Moves.from_json(content)
        assert str(caught.value).isprintable()
