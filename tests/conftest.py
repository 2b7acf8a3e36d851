"""What tests of every package share: disks that are full or read-only, and on which path kernels are compiled."""

import shutil
import subprocess
import sys

import pytest

from mossar_stream.jit.acceleration import force_plain_path

if (
    "--plain-path" in sys.argv
):  # before options are known: other conftest files import kernels as they are loaded
    force_plain_path()


def pytest_addoption(parser):
    parser.addoption(
        "--plain-path", action="store_true", help="compile kernels without numba's private parts"
    )


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
