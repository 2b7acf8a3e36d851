"""What the tests of the core share: curves that come out exactly, people that move at random, recordings."""

import json
from pathlib import Path

import hypothesis
import numpy as np
import pytest

from mossar_stream import Segmenter, Settings, Skeleton
from mossar_stream.events import to_json

hypothesis.settings.register_profile("core", deadline=None, max_examples=60, derandomize=True)
hypothesis.settings.load_profile("core")

FPS = 32.0  # dyadic, so that times and windows are exact
PAIR = Skeleton(("hip", "hand"), (-1, 0))
# The velocity of a frame is the hand's step in it, on a scale of 0..1.
ONE_STEP = {
    "window": 1 / FPS,
    "range": "fixed",
    "range_max": 1.0,
    "max_speed": 1e4,
    "level": "posture",
    "location": "none",
    "pre_roll": 0.0,
    "post_roll": 0.0,
    "tempo": False,
}


def hand_steps(curve):
    """Return frames of a hip that rests and a hand whose steps are the curve's values; the first must be 0."""
    steps = np.asarray(curve, float) * np.where(np.arange(len(curve)) % 2, 1.0, -1.0)
    frames = np.zeros((len(curve), 2, 3), np.float32)
    frames[:, 1, 0] = np.cumsum(steps)
    return frames


def events_in_chunks(segmenter, positions, times, sizes, confidence=None):
    """Return the events of all frames, pushed in chunks of these sizes in turn, and of the end of the take."""
    events, at, turn = [], 0, 0
    while at < len(positions):
        until = at + sizes[turn % len(sizes)]
        sure = None if confidence is None else confidence[at:until]
        events += segmenter.push(positions[at:until], times[at:until], sure)
        at, turn = until, turn + 1
    return events + segmenter.end_take()


def moving_people(seed, frames=240, joints=4, fps=60.0, losses=True):
    """Return positions and times of somebody who moves and rests at random, as a poor sensor sees them."""
    rng = np.random.default_rng(seed)
    pace = np.repeat(rng.choice([0.0, 0.2, 1.0, 3.0], frames // 8 + 1), 8)[:frames, None, None]
    positions = np.cumsum(rng.normal(0, 1, (frames, joints, 3)) * pace / fps, axis=0).astype(np.float32)
    times = np.arange(frames) / fps
    if losses:
        times = times + rng.uniform(0, 0.4 / fps, frames)
        positions[rng.random((frames, joints)) < 0.02] = np.nan
        positions[rng.random((frames, joints)) < 0.002] += 50.0
        at = rng.integers(1, frames, 3)
        times[at[0]] = times[at[0] - 1]
        times[at[1] :] += 0.4
        times[at[2] :] += rng.choice([0.0, 2.0, -5.0])
    return positions, times


class Core:
    """The functions above, for tests."""

    FPS, PAIR, ONE_STEP = FPS, PAIR, ONE_STEP
    hand_steps = staticmethod(hand_steps)
    events_in_chunks = staticmethod(events_in_chunks)
    moving_people = staticmethod(moving_people)

    @staticmethod
    def skeleton(joints):
        return Skeleton(tuple(f"j{i}" for i in range(joints)))

    @staticmethod
    def lines(events):
        return [to_json(event) for event in events]

    @staticmethod
    def key_frames(events, status):
        return [e for e in events if e.__struct_config__.tag == "key_frame" and e.status == status]

    @staticmethod
    def segmenter_of(curve_settings, theta):
        return Segmenter(PAIR, Settings(**{**ONE_STEP, "sig_threshold": theta, **curve_settings}), fps=FPS)


@pytest.fixture(scope="session")
def core():
    return Core


@pytest.fixture(scope="session")
def labelled():
    """Return the folder of labelled recordings beside the project."""
    folder = Path(__file__).parents[3] / "shared" / "data" / "labelled"
    if not folder.is_dir():
        pytest.skip(f"the labelled recordings are not here ({folder})")
    return folder


@pytest.fixture(scope="session")
def walk_86_01(labelled):
    """Return positions (n, 31, 3) of CMU 86_01, 120 Hz, and its skeleton."""
    from mossar_adapters.files import ReadOptions, open_recording

    recording = open_recording(labelled / "86_01.amc", ReadOptions(skeleton=labelled / "86.asf"))
    return np.concatenate([frames.positions for frames in recording.chunks()]), recording.skeleton


@pytest.fixture(scope="session")
def precog(labelled):
    """Return positions and rates of the Kinect recordings."""
    takes = []
    for path in sorted((labelled / "precog").glob("*.npz")):
        facts = json.loads(path.with_suffix(".json").read_text())
        with np.load(path) as arrays:
            takes.append((path.stem, arrays["positions"].astype(np.float32), float(facts["fps"])))
    return takes
