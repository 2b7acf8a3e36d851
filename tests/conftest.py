"""What tests of every package share: when kernels are compiled; disks that are full or read-only."""

import shutil
import subprocess

import numpy as np
import pytest

from mossar_stream import Moves, Segmenter, Settings, Skeleton, precompile


def pytest_sessionstart(session):
    """Compile once, on all cores, what otherwise every worker would compile for itself."""
    if getattr(session.config.option, "numprocesses", None):  # workers have no option of this kind
        compile_all()


def compile_all():
    """Compile the kernels of all measures, of repetitions, limbs and moves, or find them on disk."""
    for similarity in ("evidence", "path_kernel"):  # the likelihood's are among the first
        precompile(Settings(similarity=similarity))
    pair = Skeleton(("hip", "hand"), (-1, 0))
    wave = np.zeros((120, 2, 3), np.float32)
    wave[:, 1, 0] = np.sin(np.arange(120) / 20)
    moves = Moves(pair)
    moves.add("wave", wave, fps=60.0)
    Segmenter(pair, Settings(repetitions=True, limbs=True), moves=moves)


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
