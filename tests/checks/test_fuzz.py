import contextlib
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("resource", reason="limits are of POSIX systems")

from checks.fuzz import guard
from checks.fuzz.mutation import Mutator
from checks.fuzz.target import Tally, Target, run_round
from mossar_stream.errors import MossarError

ROOT = Path(__file__).parents[2]


def target(feed):
    return Target("a", 1.0, lambda: contextlib.nullcontext(feed), [b"abcdefgh"])


def test_the_same_chance_makes_the_same_inputs():
    first, second = (Mutator(random.Random(7), [b"one", b"another"], [b"word"]) for _ in range(2))
    made = [first.next() for _ in range(200)]
    assert made == [second.next() for _ in range(200)]
    assert len(set(made)) > 100
    assert b"one" in made


def test_clear_errors_are_refusals_and_others_are_crashes_kept_by_kind():
    def feed(data):
        if data.startswith(b"a"):
            raise MossarError("no")
        raise IndexError

    tally = Tally()
    run_round(target(feed), 1, 0, 100, tally)
    assert tally.inputs == tally.refused + tally.failed == 100
    assert len(tally.crashes) == 5
    assert all(crash.kind.startswith("IndexError at test_fuzz.py:") for crash in tally.crashes)


def test_a_hang_is_a_crash(monkeypatch):
    def feed(_):
        while True:
            pass

    monkeypatch.setattr(guard, "SECONDS", 0.05)
    former = signal.signal(signal.SIGALRM, guard._hang)
    tally = Tally()
    run_round(target(feed), 1, 0, 1, tally)
    signal.signal(signal.SIGALRM, former)
    assert tally.crashes[0].kind.startswith("Hang")


def test_every_target_is_fed_and_none_fails():
    places = [ROOT, ROOT / "adapters", ROOT / "tools"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
    command = [sys.executable, "-m", "checks.fuzz", "--inputs", "4000", "--seed", "9"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines()[1:-1]]
    assert len(rows) > 35
    assert all(int(row[-6]) > 0 for row in rows)


def test_without_hypothesis_one_line_says_what_to_install(tmp_path):
    (tmp_path / "hypothesis.py").write_text("raise ModuleNotFoundError(name='hypothesis')")
    places = [tmp_path, ROOT, ROOT / "adapters", ROOT / "tools"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, places))}
    command = [sys.executable, "-m", "checks.fuzz", "--inputs", "1"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "fuzzing needs hypothesis: pip install -e . --group dev\n")
