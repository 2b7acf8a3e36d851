"""Moves: examples are checked and cut, files of moves keep them, and nobody's file does harm."""

import json

import numpy as np
import pytest

from mossar_adapters.joint_sets import CMU_31, HUMANOID, KINECT_20, KINECT_25, MIXAMO
from mossar_stream import FrameError, MoveEvent, Moves, MovesError, Performers, Segmenter, Skeleton
from mossar_stream.moves.joints import shared_joints

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
        ("x", performed("punch_left"), None, "rate"),
        ("x", performed("punch_left"), "30", "rate"),
        ("x", [[["a"] * 3] * 15] * 9, FPS, "are numbers"),
        ("x", None, FPS, "15 joints"),
        (5, performed("punch_left"), FPS, "name is text"),
        ("", performed("punch_left"), FPS, "name"),
        ("a\u202eb", performed("punch_left"), FPS, "name"),
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
    assert json.loads(path.read_text())["version"] == 2
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
        changed(moves, version=4),
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


def test_a_file_in_place_of_moves_is_said(tmp_path):
    path = str(tmp_path / "moves.json")
    for user in (lambda: Segmenter(PERSON, moves=path), lambda: Performers(moves=path)):
        with pytest.raises(TypeError, match="moves are a Moves, not str"):
            user()


def test_joints_of_a_strangers_file_write_nothing_to_terminals(moves):
    skeleton = {"names": ["a\x1b[31m", *PERSON.names[1:]], "parents": PERSON.parents, "root": 0}
    strange = Moves.from_json(changed(moves, skeleton=skeleton))
    other = Moves.from_json(changed(moves, skeleton={**skeleton, "names": ["\x1b", *PERSON.names[1:]]}))
    for one in (strange, other):
        with pytest.raises(FrameError) as caught:
            Segmenter(Skeleton(("hip", "hand"), (-1, 0)), moves=one)
        assert str(caught.value).isprintable()


def test_files_in_which_nothing_moves_recognise_nothing_and_do_no_harm(moves):
    example = json.loads(moves.to_json())["examples"][0]
    count = len(example["positions"])
    far = [10_000_000 * (-1) ** i for i in range(count)]
    for positions in ([0] * count, far):
        given = Moves.from_json(changed(moves, examples=[{**example, "positions": positions}] * 2))
        segmenter = Segmenter(PERSON, moves=given, fps=FPS)
        events = [*segmenter.push(with_rest("punch_left")), *segmenter.end_take()]
        assert not [event for event in events if isinstance(event, MoveEvent)]
        assert len(given.kinds()) in (1, 2)
    empty = Segmenter(PERSON, moves=Moves(PERSON), fps=FPS)
    empty.push(with_rest("punch_left"))


@pytest.mark.parametrize("streamed", [HUMANOID, MIXAMO, KINECT_20, CMU_31])
def test_examples_of_a_kinect_serve_other_joint_sets(streamed):
    rng = np.random.default_rng(0)
    shown = np.repeat(rng.normal(0, 0.4, (1, len(KINECT_25), 3)), 40, axis=0)
    for name in ("ElbowRight", "WristRight", "HandRight"):
        shown[:, KINECT_25.index(name), 1] += 0.9 * np.sin(np.linspace(0, np.pi, 40))
    moves = Moves(KINECT_25)
    moves.add("raise", shown, FPS)
    take = np.concatenate([np.repeat(shown[:1], 40, axis=0), shown, np.repeat(shown[:1], 40, axis=0)])
    frames = np.repeat(take.mean(axis=1, keepdims=True), len(streamed), axis=1)
    _, ours, theirs = shared_joints(KINECT_25, streamed)
    for own, other in zip(ours, theirs, strict=True):
        frames[:, other.one] = take[:, own.one]
    segmenter = Segmenter(streamed, moves=moves, fps=FPS)
    events = [*segmenter.push(frames), *segmenter.end_take()]
    found = [event for event in events if isinstance(event, MoveEvent)]
    assert [(event.name, event.status, event.limb) for event in found] == [
        ("raise", "confirmed", "right_arm"),
        ("raise", "final", "right_arm"),
    ]


def test_a_movement_whose_frames_are_known_keeps_its_pauses():
    person = Skeleton(("hip", "left", "right"), (-1, 0, 0))
    up = np.sin(np.linspace(0.0, np.pi / 2, 20))
    height = np.concatenate([np.zeros(20), up, np.ones(30), up[::-1], np.zeros(20)])
    positions = np.zeros((len(height), 3, 3))
    positions[:, 1:, 0] = 0.3, -0.3
    positions[:, 1, 1] = height
    moves = Moves(person)
    moves.add("reach", positions, 30.0)
    moves.add("reach", positions, 30.0, movement=(20, 90))
    seconds = [example.seconds(3) for example in moves.examples]
    assert seconds[0] < 1.0
    assert seconds[1] == pytest.approx(70 / 30, abs=0.15)
    for wrong in ((-1, 5), (5, 4), (0, len(height))):
        with pytest.raises(MovesError, match="is not in an example"):
            moves.add("reach", positions, 30.0, movement=wrong)
