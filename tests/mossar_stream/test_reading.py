"""A recording is read and segmented in two calls, whatever its format."""

import subprocess
import sys

import numpy as np
import pytest

import mossar_stream
from mossar_adapters.files import open_recording
from mossar_stream import MossarError, Settings, segment_recording


@pytest.fixture
def path(tmp_path):
    times = np.arange(300) / 30
    positions = np.zeros((300, 3, 3), np.float32)
    positions[:, :, 1] = (1.0, 1.7, 0.1)
    positions[:, 1, 0] = np.sin(4 * times) * (times % 4 > 2)
    path = tmp_path / "take.npz"
    names = np.array(["hip", "head", "foot"])
    np.savez(path, positions=positions, fps=30.0, joint_names=names, parents=np.array([-1, 0, 0]))
    return path


def test_what_was_read_is_segmented_as_its_arrays_are(path):
    take = mossar_stream.read(path, unit="m")
    expected = segment_recording(take.positions, take.fps, take.skeleton, times=take.times)
    assert len(expected.key_frames) > 4
    for given in (take, open_recording(path)):
        result = segment_recording(given)
        assert result.key_frames == expected.key_frames
        assert result.segments == expected.segments
    assert segment_recording(take, settings=Settings(level="posture")).segments
    assert segment_recording(take, 60, times=take.times / 2).segments[-1].end_time == take.times[-1] / 2


def test_the_axis_of_a_recording_counts_unless_it_was_chosen():
    class Upwards:
        positions = np.zeros((9, 2, 3), np.float32)
        times = np.arange(9) / 30
        fps = 30.0
        skeleton = mossar_stream.Skeleton(("a", "b"), (-1, 0))
        up = "z"

    assert segment_recording(Upwards()).settings.up == "z"
    assert segment_recording(Upwards(), settings=Settings(up="-y")).settings.up == "-y"


def test_what_cannot_be_read_is_one_line(tmp_path):
    with pytest.raises(MossarError, match=r"none\.bvh: cannot be opened"):
        mossar_stream.read(tmp_path / "none.bvh")


def test_the_readers_are_loaded_when_they_are_needed():
    code = "import sys, mossar_stream; mossar_stream.read; sys.exit('mossar_adapters' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
