"""Labelled takes, turned and shifted: where somebody stands, and which way they look, is not what they do."""

from pathlib import Path

import numpy as np
import pytest

from mossar_adapters.files import ReadOptions, open_recording
from mossar_stream import KeyFrameEvent, Segmenter, Settings
from mossar_tools.evaluation.takes import load_folder

DATA = Path(__file__).parents[4] / "shared" / "data" / "labelled"
EVERY = 12  # take; of all of them, 99.7 % were found again (docs/accuracy.md)
NEAR = 0.1  # s


@pytest.fixture(scope="module")
def takes():
    if not DATA.is_dir():
        pytest.skip("needs ../shared/data/labelled")
    chosen = load_folder(DATA, lambda _: None)[::EVERY]
    assert len(chosen) >= 8
    return chosen


def final(take, positions):
    """Return the times of the final key frames, s."""
    segmenter = Segmenter(take.skeleton, Settings(), fps=take.fps)
    events = segmenter.push(positions, take.times) + segmenter.end_take()
    return sorted(e.time for e in events if isinstance(e, KeyFrameEvent) and e.status == "final")


def found_again(times, others, near):
    """Return how many times have another one near them, one to one."""
    count, rest = 0, list(others)
    for time in times:
        while rest and rest[0] < time - near:
            rest.pop(0)
        if rest and rest[0] <= time + near:
            rest.pop(0)
            count += 1
    return count


def turned(positions, axis):
    c, s = np.cos(np.deg2rad(37.0)), np.sin(np.deg2rad(37.0))
    about = {"y": [[c, 0, s], [0, 1, 0], [-s, 0, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis]
    return np.asarray(positions, float) @ np.array(about).T


# y is up; by what is upright is told at which end a repetition begins, and by nothing else.
@pytest.mark.parametrize(("axis", "least"), [("y", 0.97), ("z", 0.9)])
def test_turned_by_37_degrees_nearly_all_key_frames_stay(takes, axis, least):
    whole = again = 0
    for take in takes:
        straight, other = final(take, take.positions), final(take, turned(take.positions, axis))
        whole += max(len(straight), len(other))
        again += found_again(straight, other, NEAR)
    assert whole > 100
    assert again >= least * whole


def test_in_millimetres_all_key_frames_stay(takes, tmp_path):
    for take in takes:
        path = tmp_path / f"{take.name.replace('/', '-')}.npz"
        names, parents = np.array(take.skeleton.names), np.array(take.skeleton.parents)
        np.savez(
            path,
            positions=np.asarray(take.positions, float) * 1000,
            fps=take.fps,
            joint_names=names,
            parents=parents,
        )
        read = open_recording(path, ReadOptions(unit="mm"))
        positions = np.concatenate([frames.positions for frames in read.chunks()])
        straight, other = final(take, take.positions), final(take, positions)
        assert found_again(straight, other, NEAR) >= 0.97 * max(len(straight), len(other)), take.name


def test_shifted_by_ten_kilometres_all_key_frames_stay_with_joints_missing_too(takes):
    rng = np.random.default_rng(3)
    for take in takes:
        holes = np.array(take.positions, float)
        holes[rng.random(holes.shape[:2]) < 0.03] = np.nan
        holes[:, -1] = np.nan  # never seen
        middle = len(holes) // 3
        holes[middle : middle + 200, 1] = np.nan
        assert final(take, holes + np.array([-9_999.9, 5.0, 8_888.8])) == final(take, holes), take.name
