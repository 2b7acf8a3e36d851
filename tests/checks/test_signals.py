"""The check of signalled starts: what it calls a fault, and that it can be run in parts."""

import os
import signal
import sys

import pytest

if os.name != "posix":
    pytest.skip("signals of POSIX systems", allow_module_level=True)

from checks.signals import Outcome, main

LOST = "Exception ignored in: <function _get_module_lock.<locals>.cb at 0x7f81536bef20>"


@pytest.mark.parametrize(
    ("number", "took", "status", "words", "fault"),
    [
        (signal.SIGINT, 0.3, 130, "mossar: osc://127.0.0.1:0: listening\n", ""),
        (signal.SIGTERM, 0.3, -15, "", ""),
        (signal.SIGINT, 0.3, -2, "Traceback (most recent call last):\nKeyboardInterrupt\n", ""),
        (
            signal.SIGINT,
            0.0,
            1,
            "Fatal Python error: init_import_site: Failed to import the site module\n",
            "",
        ),
        (signal.SIGINT, 0.2, 1, "Could not import runpy module\nTraceback (most recent call last):\n", ""),
        (signal.SIGINT, 60.1, -9, f"{LOST}\nKeyboardInterrupt:\n", ""),
        (signal.SIGTERM, 60.1, -9, f"{LOST}\nKeyboardInterrupt:\n", "took 60.1 s"),
        (signal.SIGTERM, 0.0, 1, "Fatal Python error: init_import_site: Failed\n", "status 1"),
        (signal.SIGINT, 2.3, 130, "", "took 2.3 s"),
        (signal.SIGTERM, 0.3, 130, "", "status 130"),
        (signal.SIGINT, 0.3, 1, "mossar: internal error, please report it", "status 1"),
        (signal.SIGINT, 0.3, 130, "Exception ignored in: <function>", "said 'Exception ignored'"),
        (signal.SIGINT, 0.3, 130, "Traceback (most recent call last):", "said 'Traceback'"),
    ],
)
def test_faults_are_told_from_what_must_be(number, took, status, words, fault):
    assert Outcome(0, number, 1.0, took, status, words).fault(2.0) == fault


def test_it_runs_in_parts_whose_results_are_summed(tmp_path, monkeypatch, capsys):
    results = tmp_path / "starts.jsonl"
    common = ["--starts", "3", "--latest", "0.6", "--limit", "20", "--results", str(results)]
    for part, made in (("2", 2), ("2", 3), ("2", 3)):
        monkeypatch.setattr(sys, "argv", ["signals", *common, "--at-most", part])
        assert main() == 0, capsys.readouterr().out
        assert len(results.read_text().splitlines()) == made
        assert f"{made} starts, 0 faults" in capsys.readouterr().out
