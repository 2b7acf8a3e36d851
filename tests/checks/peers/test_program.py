"""The program that compares with other libraries."""

import subprocess
import sys

import pytest

from mossar_adapters.extras import installed


def test_peers_that_are_missing_are_one_line():
    if any(installed(name) for name in ("river", "stumpy", "claspy", "ruptures")):
        pytest.skip("there are peers")
    done = subprocess.run([sys.executable, "-m", "checks.peers"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "pip install 'mossar-stream[peers]'" in done.stderr
    assert len(done.stderr.splitlines()) == 1
