"""Moves from any side: turned, turning, mirrored; and what files may say of it."""

import json

import numpy as np
import pytest

from mossar_stream import MoveEvent, MoveRule, Moves, MovesError, Segmenter, Skeleton

from .conftest import FPS, MOVES, PERSON, performed, session

ORDER = ["punch_left", "kick_right", "circle_left", "punch_right"]


@pytest.fixture(scope="module")
def take():
    return session(ORDER)


def turned(positions, degrees):
    """Return positions turned about the vertical by an angle, or one for each frame."""
    a = np.radians(np.broadcast_to(degrees, len(positions)))[:, None]
    x, y, z = np.moveaxis(positions, -1, 0)
    return np.stack([np.cos(a) * x + np.sin(a) * z, y, np.cos(a) * z - np.sin(a) * x], axis=-1).astype(
        np.float32
    )


def names_in(positions, moves, skeleton=PERSON):
    segmenter = Segmenter(skeleton, moves=moves, fps=FPS)
    events = [*segmenter.push(positions), *segmenter.end_take()]
    return [event.name for event in events if isinstance(event, MoveEvent) and event.status == "confirmed"]


def changed(moves, **fields):
    return json.dumps({**json.loads(moves.to_json()), **fields}).encode()


@pytest.mark.parametrize("degrees", [30, 90, 180, -135])
def test_a_performer_may_stand_at_any_angle(moves, take, degrees):
    assert names_in(turned(take[0], degrees), moves) == ORDER


def test_a_performer_may_turn_meanwhile(moves, take):
    positions, times, _ = take
    assert names_in(turned(positions, 15 * times), moves) == ORDER


def test_as_shown_wants_the_side_that_was_shown(moves, take):
    mine = moves.copy()
    mine.facing = "as_shown"
    assert names_in(take[0], mine) == ORDER
    assert names_in(turned(take[0], 90), mine) == []


def test_without_hips_moves_are_recognised_as_shown(take):
    hand = [name for name in PERSON.names if "hip" not in name]
    bare = Skeleton(tuple(f"part{i}" for i in range(len(hand))), (-1, *[0] * (len(hand) - 1)))
    joints = [PERSON.index(name) for name in hand]
    moves = Moves(bare)
    for name in MOVES:
        moves.add(name, performed(name)[:, joints], FPS)
    assert moves.facing == "any"
    assert names_in(take[0][:, joints], moves, bare) == ORDER
    assert names_in(turned(take[0][:, joints], 90), moves, bare) != ORDER


def test_the_mirror_image_has_the_name_of_the_other_side(moves, take):
    mine = moves.copy()
    mine.remove("punch_right")
    mine.set_rule("punch_left", mirrored=True)
    assert mine.reported == ("punch_left", "circle_left", "kick_right", "punch_right")
    assert mine.rule("punch_right") == MoveRule(mirrored=True)
    assert names_in(take[0], mine) == ORDER
    assert names_in(turned(take[0], 70), mine) == ORDER


def test_the_mirror_image_of_a_move_without_a_side_has_its_name(take):
    mine = Moves(PERSON)
    mine.add("punch", performed("punch_left"), FPS)
    mine.set_rule("punch", mirrored=True)
    found = names_in(take[0], mine)
    assert found.count("punch") == 2


def test_a_mirror_image_is_where_the_other_side_would_be():
    mine = Moves(PERSON)
    for name in ("punch_left", "punch_right"):
        mine.add(name, turned(performed(name), 25), FPS)
    mine.set_rule("punch_left", mirrored=True)
    (image,) = mine.mirror_images()
    wanted = mine.examples[1]
    assert image.name == "punch_right"
    assert np.abs(image.metres(15) - wanted.metres(15)).max() < 0.03  # performances differ that much


def test_joints_without_sides_cannot_be_mirrored():
    mine = Moves(Skeleton(("hip", "hand"), (-1, 0)))
    wave = np.zeros((30, 2, 3))
    wave[:, 1, 0] = np.sin(np.linspace(0, 6, 30))
    mine.add("wave", wave, FPS)
    with pytest.raises(MovesError, match="left and right"):
        mine.set_rule("wave", mirrored=True)
    one_arm = Moves(Skeleton(("hips", "right_wrist"), (-1, 0)))
    one_arm.add("wave", wave, FPS)
    with pytest.raises(MovesError, match="both sides"):
        one_arm.set_rule("wave", mirrored=True)


def test_files_keep_facing_and_rules(moves):
    mine = moves.copy()
    mine.facing = "as_shown"
    mine.set_rule("punch_left", strict=0.8, again=0.5)
    mine.set_rule("kick_right", strict=0.9)
    mine.set_rule("kick_right", strict=0.5)
    again = Moves.from_json(mine.to_json())
    assert (again.facing, again.rule("punch_left")) == ("as_shown", MoveRule(strict=0.8, again=0.5))
    assert json.loads(mine.to_json())["rules"] == {"punch_left": {"strict": 0.8, "again": 0.5}}
    again.remove("punch_left")
    assert again.rule("punch_left") == MoveRule()
    assert Moves.from_json(again.to_json()).names == again.names


def test_files_of_version_1_are_read(moves):
    content = json.loads(moves.to_json())
    for new in ("facing", "rules"):
        del content[new]
    examples = [{key: one[key] for key in ("name", "fps", "positions")} for one in content["examples"]]
    old = Moves.from_json(json.dumps({**content, "version": 1, "examples": examples}).encode())
    assert (old.names, old.facing, old.rule("kick_right")) == (moves.names, "any", MoveRule())


@pytest.mark.parametrize(
    "fields",
    [
        {"facing": "left"},
        {"facing": None},
        {"rules": []},
        {"rules": {"nobody": {"strict": 0.8}}},
        {"rules": {"kick_right": {"strict": 1.5}}},
        {"rules": {"kick_right": {"again": -1}}},
        {"rules": {"kick_right": {"again": 1e9}}},
        {"rules": {"kick_right": {"mirrored": "yes"}}},
        {"rules": {"kick_right": {"loud": True}}},
        {"rules": {"\x1b[31m": {"strict": 0.8}}},
    ],
)
def test_rules_of_strangers_are_refused_in_one_line(moves, fields):
    with pytest.raises(MovesError) as caught:
        Moves.from_json(changed(moves, **fields))
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("name", "rule", "says"),
    [
        ("punch_left", {"strict": 1.1}, "strict is a number from 0 to 1"),
        ("punch_left", {"strict": "0.5"}, "strict is a number"),
        ("punch_left", {"again": float("nan")}, "again is a number"),
        ("punch_left", {"again": True}, "again is a number"),
        ("punch_left", {"mirrored": 1}, "True or False"),
        ("nothing", {"strict": 0.5}, "no move called 'nothing'"),
    ],
)
def test_rules_are_checked(moves, name, rule, says):
    mine = moves.copy()
    with pytest.raises(MovesError, match=says):
        mine.set_rule(name, **rule)
    with pytest.raises(MovesError, match="any, as_shown"):
        mine.facing = "left"
