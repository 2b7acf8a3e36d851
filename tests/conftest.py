"""What tests of every package share: disks that are full or read-only, and events."""

import os
import shutil
import subprocess

# Tests run side by side, and matrices are small: threads of the linear algebra would only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from mossar_stream import FollowEvent, KeyFrameEvent, MoveEvent, PoseEvent, RepetitionEvent, SegmentEvent


def mounted(folder, *options):
    """Mount a disk in memory, or skip where that is not allowed."""
    folder.mkdir(exist_ok=True)
    if shutil.which("mount") is None:
        pytest.skip("there is no mount here")
    command = ["mount", "-t", "tmpfs", *options, "none", str(folder)]
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode != 0:
        pytest.skip("disks cannot be mounted here; root can on Linux")
    return folder


@pytest.fixture
def disk_of_128k(tmp_path):
    """A disk of 128 KiB."""
    folder = mounted(tmp_path / "small", "-o", "size=128k")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.fixture
def read_only_disk(tmp_path):
    """A disk on which nothing can be written."""
    folder = mounted(tmp_path / "read-only", "-o", "ro")
    yield folder
    subprocess.run(["umount", "-l", str(folder)], check=True)


WHO = {"performer": "p1", "rev": 1, "take": 0}
LIMBS = {"trunk": 5.0, "left_leg": 12.0}
MADE = {
    KeyFrameEvent: {
        "id": "p1/0/7",
        "status": "confirmed",
        "decided": False,
        "kind": "onset",
        "frame": 7,
        "time": 0.2,
    }
    | {"decided_frame": 9, "decided_time": 0.3, "velocity": 0.1, "strength": None},
    SegmentEvent: {"id": "p1/0/0-9", "status": "final", "state": "moving", "start_frame": 0, "end_frame": 9}
    | {"start_time": 0.0, "end_time": 0.3, "active_joints": ("hand",), "similarity": None},
    RepetitionEvent: {
        "id": "p1/0/r2",
        "status": "counted",
        "channel": "body",
        "count": 2,
        "total": 2,
        "period": 2.0,
    }
    | {"tempo": 30.0, "start": 1.0, "end": 2.0, "amplitude": 0.5, "joint": "hand", "decided_time": 3.0},
    FollowEvent: {
        "id": "p1/follow/0/3",
        "name": "squat",
        "status": "progress",
        "count": 2,
        "start": 12.0,
        "time": 13.0,
    }
    | {
        "progress": 0.5,
        "tempo": 1.25,
        "certainty": 0.75,
        "deviation": 8.0,
        "limbs": LIMBS,
        "joint": "LeftKnee",
    }
    | {"range": None, "score": None, "decided_time": 13.5},
    MoveEvent: {"id": "p1/move/0/4", "name": "jab", "status": "confirmed", "start": 12.0, "end": 12.5}
    | {"score": 0.8, "limb": "left_arm", "decided_time": 12.5},
    PoseEvent: {"id": "p1/pose/0/2", "name": "plank", "status": "held", "start": 12.0, "seconds": 1.5}
    | {"deviation": 8.0, "limbs": LIMBS, "joint": "LeftKnee", "decided_time": 13.5},
}


@pytest.fixture(scope="session")
def made():
    """Return what makes events: `made(FollowEvent, status="done")` has plausible values in all other fields."""

    def make(record, /, **fields):
        return record(**{**WHO, **MADE[record], **fields})

    return make
