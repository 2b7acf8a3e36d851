"""A stream's unit fits the body, and joints that are no part of it are named while it runs."""

import logging

import numpy as np
import pytest

from checks.walking_body import BODY, NAMES, walking, with_joints_above
from mossar_adapters.files.options import ReadOptions
from mossar_adapters.receiving.checked import HELD, BodySource, CheckedSource
from mossar_adapters.source import Departure, Meta
from mossar_stream import Frames, Skeleton


class Given:
    """A source of given items."""

    name, live, counters = "given:", True, "its own"

    def __init__(self, items):
        self.given = items

    def items(self):
        yield from self.given

    def close(self):
        pass


def stream(skeleton, positions, size=1, performer="p1"):
    frames = [
        Frames(
            positions[n : n + size].astype(np.float32),
            np.arange(n, n + len(positions[n : n + size])) / 60,
            None,
            performer,
        )
        for n in range(0, len(positions), size)
    ]
    return [Meta(performer, skeleton), *frames]


def checked(items, **options):
    found = list(CheckedSource(Given(items), ReadOptions(**options)).items())
    metas = [item for item in found if isinstance(item, Meta)]
    positions = [item.positions for item in found if isinstance(item, Frames)]
    return metas, np.concatenate(positions)


@pytest.mark.parametrize("size", [1, 7, 500])
@pytest.mark.parametrize(("scale", "unit"), [(1000.0, "mm"), (100.0, "cm"), (1.0, "")])
def test_a_unit_that_fits_is_taken_from_the_first_frame_on(size, scale, unit, caplog):
    with caplog.at_level(logging.INFO):
        metas, positions = checked(stream(BODY, scale * walking(), size))
    assert np.allclose(positions, walking(), atol=1e-3)
    assert len(metas) == 1
    assert [f"unit taken as {unit}" in line for line in caplog.messages] == ([True] if unit else [])


def test_the_unit_that_the_user_gives_is_kept(caplog):
    _, positions = checked(stream(BODY, 1000.0 * walking()), unit="m")
    assert np.allclose(positions, 1000.0 * walking(), rtol=1e-5)
    assert "check --unit" in caplog.text


def test_a_size_that_no_unit_fits_is_logged_and_kept(caplog):
    _, positions = checked(stream(BODY, 0.0125 * walking()))
    assert np.allclose(positions, 0.0125 * walking(), rtol=1e-4, atol=1e-6)
    assert "the body is 2 cm tall; set --unit" in caplog.text


def test_frames_wait_only_while_the_size_is_open():
    items = stream(BODY, 1000.0 * walking(HELD + 2))
    source = CheckedSource(Given([]), ReadOptions())
    source._source.given = items[: HELD - 1]
    assert sum(isinstance(item, Frames) for item in source.items()) == HELD - 2  # the source ended
    idle = checked([*items[:2], None, *items[2:]])[1]
    assert np.allclose(idle, walking(HELD + 2), atol=1e-3)


def test_a_body_that_is_not_seen_yet_is_measured_later():
    frames = 1000.0 * walking(30)
    frames[:10] = np.nan
    _, positions = checked(stream(BODY, frames))
    assert len(positions) == 30
    assert np.allclose(positions[10:], walking(30)[10:], atol=1e-3)


@pytest.mark.parametrize("names", [("joint_Root",), ("World", "Armature")])
def test_a_joint_above_the_body_is_named_before_the_first_frame(names, caplog):
    skeleton, positions = with_joints_above(names, (0.0, 0.0, 0.0))
    metas, frames = checked(stream(skeleton, positions(walking())))
    assert [meta.reference for meta in metas] == [(), names]
    assert metas[-1].skeleton.names[metas[-1].skeleton.root] == "Hips"
    assert frames.shape[1] == len(names) + len(NAMES)  # frames keep it
    assert caplog.text.count("of the body") == 1


def test_a_joint_without_a_name_is_judged_by_what_it_does():
    skeleton, positions = with_joints_above(("a",), (0.0, 0.95, 0.0))
    skeleton = Skeleton(tuple(f"n{joint}" for joint in range(len(skeleton))), skeleton.parents)
    found = list(
        CheckedSource(Given(stream(skeleton, positions(walking(480, way=12.0)))), ReadOptions()).items()
    )
    place = next(n for n, item in enumerate(found) if isinstance(item, Meta) and item.reference)
    assert found[place].reference == ("n0",)
    assert place <= 62


def test_the_same_meta_again_keeps_what_was_found():
    skeleton, positions = with_joints_above(("joint_Root",), (0.0, 0.0, 0.0))
    items = stream(skeleton, positions(walking(20)))
    metas, _ = checked([*items[:10], items[0], *items[10:]])
    assert [meta.reference for meta in metas] == [(), ("joint_Root",), ("joint_Root",)]


def test_a_root_that_the_user_names_stays():
    skeleton, positions = with_joints_above(("joint_Root",), (0.0, 0.0, 0.0))
    metas, _ = checked(stream(skeleton, positions(walking())), root="joint_Root")
    assert len(metas) == 1


def test_performers_are_judged_one_by_one_and_leave():
    items = [
        *stream(BODY, 1000.0 * walking(20)),
        *stream(BODY, walking(20), performer="p2"),
        Departure("p1", "left"),
    ]
    found = list(CheckedSource(Given(items), ReadOptions()).items())
    heights = {
        name: [np.ptp(i.positions[..., 1]) for i in found if isinstance(i, Frames) and i.performer == name]
        for name in ("p1", "p2")
    }
    assert max(heights["p1"] + heights["p2"]) < 2
    assert min(heights["p1"] + heights["p2"]) > 1
    assert isinstance(found[-1], Departure)
    assert CheckedSource(Given([]), ReadOptions()).counters == "its own"


def test_slots_compare_bodies_only():
    skeleton, positions = with_joints_above(("joint_Root",), (0.0, 0.0, 0.0))
    source = BodySource(CheckedSource(Given(stream(skeleton, positions(walking()))), ReadOptions()))
    found = list(source.items())
    assert [len(item.skeleton) for item in found if isinstance(item, Meta)] == [len(skeleton), len(BODY)]
    assert {item.positions.shape[1] for item in found if isinstance(item, Frames)} == {len(BODY)}
