"""The program that repeats the paper's experiments."""

import json
import subprocess
import sys

import pytest


def paper(*arguments):
    command = [sys.executable, "-m", "checks.paper", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["nowhere"], "there is no such folder"),
        (["demo:", "--preset", "game"], "leave --preset out"),
        (["osc://127.0.0.1:9000"], "takes a folder of labelled recordings or demo:"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(arguments, problem):
    done = paper(*arguments)
    assert done.returncode == 2
    assert problem in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_tables_and_numbers_of_the_built_in_performer(tmp_path):
    done = paper("demo:?fps=30&seconds=3", "--seeds", "1", "--json", str(tmp_path / "paper.json"))
    assert done.returncode == 0, done.stderr
    grids = [line for line in done.stderr.splitlines() if " grids: " in line]
    assert [line.split(" grids: ")[0].split()[-3:] for line in grids] == [
        [str(number), "of", str(len(grids))] for number in range(1, len(grids) + 1)
    ]
    assert len(grids) % 5 == 0
    assert "Table 3. Averaged best performances after remerging" in done.stdout
    found = json.loads((tmp_path / "paper.json").read_text())
    assert {grid["method"] for grid in found["remerging"]} >= {"Mossar", "Mossar, damped kernel"}
