"""What is timed alone does what the core does, and the program measures all of it."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from checks.reference import path_kernel as path_reference
from checks.speed.__main__ import OWN
from checks.speed.paths import pair_of, segments_of
from checks.speed.splitting import SETTINGS, run_splitting
from mossar_adapters.files.loaded import LoadedRecording
from mossar_stream.core.kernels import sum_of_paths
from mossar_stream.recording import segment_recording
from mossar_tools.bench.motion import performer

ROOT = Path(__file__).parents[3]


def test_splitting_alone_finds_the_key_frames_of_the_core():
    long = performer(30.0)
    count = len(long.times) // 2 + 1
    result = segment_recording(long.positions[:count], long.fps, long.skeleton, SETTINGS)
    found = run_splitting(long, long.chunks(count, 1000))
    # At the end the core takes back a key frame that was confirmed early.
    assert 0 <= found - len(result.key_frames) <= 1
    assert found > 5


def test_the_pairs_that_are_summed_are_those_of_the_path_kernel():
    long = performer(20.0)
    whole = LoadedRecording("x", long.skeleton, long.fps, long.positions, long.times)
    left, right = segments_of(whole)[0]
    graphs = [path_reference.segment_graph(*part, 10, 1) for part in (left, right)]
    expected = path_reference.kernel(*graphs, "normalised")
    assert sum_of_paths(*pair_of(*graphs), 1) == pytest.approx(expected, rel=1e-12)


def test_the_program_measures_everything():
    places = [ROOT, ROOT / "adapters", ROOT / "tools"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
    done = subprocess.run(
        [sys.executable, "-m", "checks.speed", "--quick", "--json"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    rows = json.loads(done.stdout)["measurements"]
    assert {row["part"] for row in rows} == set(OWN)
    assert {"osc, in and out: p50", "zmq, in and out: p99"} < {row["name"] for row in rows}
