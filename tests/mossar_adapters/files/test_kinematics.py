import numpy as np
import pytest

from mossar_adapters.files.kinematics import (
    MotionChunk,
    euler_rotations,
    joint_positions,
    joints_by_depth,
    quaternions,
    rest_positions,
)


def rotation(axis, degrees):
    return euler_rotations(np.radians([degrees]), axis)


def test_a_quarter_turn_about_z_takes_x_to_y():
    np.testing.assert_allclose(rotation("z", 90) @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(rotation("x", 90) @ [0, 1, 0], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(rotation("y", 90) @ [0, 0, 1], [1, 0, 0], atol=1e-15)


def test_the_order_of_axes_is_the_order_of_the_product():
    angles = np.radians([30.0, 40.0, 50.0])
    expected = rotation("z", 30) @ rotation("x", 40) @ rotation("y", 50)
    np.testing.assert_allclose(euler_rotations(angles, "zxy"), expected, atol=1e-15)


def test_joints_turn_all_that_hangs_on_them():
    parents = (-1, 0, 1)
    turns = np.stack([rotation("z", 90), rotation("z", 90), np.eye(3)])[None]
    offsets = np.array([[[5.0, 0, 0], [1, 0, 0], [1, 0, 0]]])
    positions = joint_positions(MotionChunk(turns, offsets, np.zeros(1)), parents)
    np.testing.assert_allclose(positions[0], [[5, 0, 0], [5, 1, 0], [4, 1, 0]], atol=1e-15)


def test_children_may_stand_before_their_parents():
    assert [list(level) for level in joints_by_depth((1, -1, 0))] == [[0], [2]]
    np.testing.assert_array_equal(rest_positions(np.eye(3), (1, -1, 0))[0], [[1, 1, 0], [0, 1, 0], [1, 1, 1]])


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("degrees", [0, 10, 90, 179, 180, 181, 359])
def test_quaternions_turn_like_their_matrices(axis, degrees):
    x, y, z, w = quaternions(rotation(axis, degrees))
    assert w >= 0
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    np.testing.assert_allclose(turned, rotation(axis, degrees), atol=1e-12)


def test_quaternions_of_many_frames_have_their_shape_and_length():
    angles = np.random.default_rng(1).uniform(-4, 4, (5, 7, 3))
    found = quaternions(euler_rotations(angles, "xyz"))
    assert found.shape == (5, 7, 4)
    np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1)
