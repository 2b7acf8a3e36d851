"""Skeletons: what they may be, and parts of them."""

import msgspec
import numpy as np
import pytest

from mossar_stream import FrameError, Skeleton
from mossar_stream.skeleton import MAX_JOINTS, MAX_NAME

BODY = Skeleton(("hip", "spine", "head", "hand", "foot"), (-1, 0, 1, 1, 0))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (((),), "1 to 1024 joints, not 0"),
        ((tuple(f"j{i}" for i in range(MAX_JOINTS + 1)),), "1 to 1024 joints, not 1025"),
        ((("a", "b"), (-1,)), "2 joint names but 1 parents"),
        ((("a", "b"), (-1, 2)), "parent 2 of joint 1"),
        ((("a", "b"), (-1, -2)), "parent -2 of joint 1"),
        ((("a", "b", "c"), (2, 3, 1)), "parent 3 of joint 1"),
        ((("a", "b", "c"), (-1, 2, 1)), "cycle"),
        ((("a", "b"), (0, 0)), "cycle"),
        ((("a", "a"),), "two joints are called 'a'"),
        ((("a", ""),), "1 to 128 characters"),
        ((("a", "b" * (MAX_NAME + 1)),), "1 to 128 characters"),
        ((("a", "b"), (-1, 0), 2), "root 2 is not one of 2 joints"),
        ((("a", "b"), (-1, 0), -2), "root -2"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_no_skeleton_can_be_is_refused_with_one_line(arguments, said):
    with pytest.raises(FrameError) as refused:
        Skeleton(*arguments)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 200


def test_names_and_parents_may_be_lists_and_arrays_as_recordings_have_them():
    plain = Skeleton(("hip", "hand"), (-1, 0))
    for given in (
        Skeleton(["hip", "hand"], [-1, 0]),
        Skeleton(np.array(["hip", "hand"]), np.array([-1, 0], np.int16), np.int64(0)),
        Skeleton(tuple(np.array(["hip", "hand"])), tuple(np.array([-1, 0]))),
    ):
        assert given == plain
        assert hash(given) == hash(plain)
        assert msgspec.msgpack.encode(given) == msgspec.msgpack.encode(plain)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("ab",), "not one text, 'ab'"),
        (((1, 2),), "names of joints are texts"),
        ((("a", "b"), (-1.0, 0.0)), "whole numbers"),
        ((("a", "b"), (-1, 0), 0.5), "whole numbers"),
    ],
)
def test_what_is_of_another_kind_is_refused(arguments, said):
    with pytest.raises(TypeError, match=said):
        Skeleton(*arguments)


def test_joints_need_no_parents_and_no_root():
    assert Skeleton(("a", "b")).parents == (-1, -1)
    assert Skeleton(("a", "b")).bones() == []
    assert Skeleton(("a", "b"), root=-1).root == -1


def test_the_most_joints_are_taken():
    chain = Skeleton(tuple(f"j{i}" for i in range(MAX_JOINTS)), tuple(range(-1, MAX_JOINTS - 1)))
    assert len(chain) == MAX_JOINTS
    assert len(chain.bones()) == MAX_JOINTS - 1


def test_a_joint_is_found_by_its_name():
    assert BODY.index("hand") == 3
    with pytest.raises(FrameError, match="no joint called 'tail'; there are hip, spine"):
        BODY.index("tail")


def test_part_of_a_skeleton_hangs_together_by_the_nearest_ancestors():
    part = BODY.select(("head", "hip", "hand"))
    assert (part.names, part.parents, part.root) == (("head", "hip", "hand"), (1, -1, 1), 1)
    rootless = BODY.select(("head", "hand"))
    assert (rootless.parents, rootless.root) == ((-1, -1), 0)
    assert BODY.select(("spine", "head")).root == 0
    for wrong in ((), ("hand", "hand"), ("tail",)):
        with pytest.raises(FrameError):
            BODY.select(wrong)


def test_another_joint_may_be_the_root():
    assert BODY.with_root("spine").root == 1
    with pytest.raises(FrameError):
        BODY.with_root("tail")


def test_a_skeleton_survives_a_wire_and_a_bad_one_does_not():
    assert msgspec.json.decode(msgspec.json.encode(BODY), type=Skeleton) == BODY
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(b'{"names": ["a", "a"]}', type=Skeleton)
