"""Cells of tables: no formulas, nothing lost, and no table is written by any other way."""

import ast
import csv
import io
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import mossar_adapters
import mossar_tools
from mossar_adapters.table_text import cell, csv_text, without_guard
from mossar_tools.dashboard.exports import key_frames_csv
from mossar_tools.marks import Mark
from mossar_tools.outputs import _csv_text

FORMULAS = [
    "=1+1",
    "+A1",
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "\r=1",
    "\n=1",
    "  =1",
    "\uff1d1",
    "-1_0",
    "-",
    "-1 ",
    "+\u0661",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_what_would_begin_a_formula_is_guarded(text):
    assert cell(text) == f"'{text}"
    assert without_guard(cell(text)) == text


@pytest.mark.parametrize(
    "text", ["", "p1", "-1", "+2.5", "-0.0001", "-1e-05", "-.5", "-inf", "a=b", "'s", "é"]
)
def test_numbers_and_plain_names_stay_as_they_are(text):
    assert cell(text) == without_guard(text) == text


@given(st.text(st.sampled_from("'=+-@\t\r\n 1a\uff1d")) | st.text())
@example("'=1")
def test_nothing_is_lost(text):
    assert without_guard(cell(text)) == text


def test_numbers_are_cells_as_they_are():
    assert csv_text([["=x", -1, -2.5, None, True]]) == "'=x,-1,-2.5,,True\n"


def test_tables_of_commands_and_of_the_dashboard_are_guarded():
    text = _csv_text(("recording", "@column"), [{"recording": "=take.bvh", "@column": -1.5}])
    assert list(csv.reader(io.StringIO(text))) == [["'=take.bvh", "-1.5"]]
    marks = [("=cmd()", Mark("7", 0.25, 7, "onset", 0.1, None, True))]
    assert key_frames_csv(marks).decode().splitlines()[1] == "'=cmd(),0.2500,7,onset,0.1000,,yes"


@pytest.mark.parametrize("package", [mossar_adapters, mossar_tools])
def test_no_table_is_written_by_another_way(package):
    folder = Path(package.__file__).parent
    found = [
        f"{file.name}: {node.attr}"
        for file in folder.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and node.attr in {"writer", "DictWriter"}
    ]
    assert found == (["table_text.py: writer"] if package is mossar_adapters else [])
