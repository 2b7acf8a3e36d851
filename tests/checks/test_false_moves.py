"""What is said that nobody asked for: counted by recording, in the minutes that have the joints."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from checks.false_moves import MOST, Player, count, line_of, skeleton_of
from mossar_adapters.demo import performance
from mossar_stream import Skeleton
from mossar_tools.evaluation.sessions import Examples, load_examples
from mossar_tools.evaluation.takes import Take, load_folder

SHARED = Path(__file__).parents[3] / "shared" / "data"
KINECT, LABELLED = SHARED / "moves" / "kinect", SHARED / "labelled"
FPS = 60.0


@pytest.fixture(scope="module")
def take():
    own = performance(1, fps=FPS, seconds=6)
    frames = own.frames
    return Take("precog/a", "a", "motion", own.skeleton, FPS, frames.positions, frames.times, [], 0.1)


def test_what_is_said_is_counted_and_recordings_without_the_joints_are_not(take):
    shown = {"mine": [take.positions[200:260].astype(np.float64)]}
    examples = Examples(shown, {"mine": [FPS]}, take.skeleton)
    markers = Skeleton(tuple(f"m{j}" for j in range(len(take.skeleton))), (), -1)
    player = count("ann", examples, [take, msgspec.structs.replace(take, name="b", skeleton=markers)])
    assert (player.seconds, player.refused) == (take.duration, 1)
    assert player.said
    assert {move for _, move in player.said} == {"mine"}
    assert player.in_ten_minutes == pytest.approx(600 * len(player.said) / player.seconds)
    assert line_of(player).split()[:3] == ["ann", f"{player.seconds / 60:.1f}", str(len(player.said))]


def test_exercises_that_are_the_same_movement_do_not_count():
    player = Player("ann", 600.0, 0, [("ui_prmd/m05_s01", "duck"), ("m05_s02", "jab"), ("precog/a", "duck")])
    assert (player.alike, player.in_ten_minutes) == (1, 2.0)


def test_nobody_seen_is_nothing_said():
    assert Player("ann", 0.0, 3, []).in_ten_minutes == 0.0


@pytest.mark.skipif(
    not (KINECT.is_dir() and LABELLED.is_dir()), reason="the recordings are not in ../shared/data"
)
def test_a_players_moves_are_hardly_ever_said_of_others():
    examples = load_examples(KINECT / "samples" / "U105.npz", skeleton_of(KINECT))
    takes = [*load_folder(LABELLED / "ui_prmd")[:8], *load_folder(LABELLED / "gesture_phase")[:1]]
    player = count("U105", examples, takes)
    assert player.refused == 1  # upper bodies
    assert player.seconds > 120
    assert player.in_ten_minutes <= MOST
