"""Examples in docstrings are run: they are part of the documentation."""

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("mossar_stream", "adapters/mossar_adapters", "tools/mossar_tools", "tools/checks")


def modules():
    for package in PACKAGES:
        home = ROOT / package
        for path in sorted(home.rglob("*.py")):
            if ">>> " in path.read_text():
                yield ".".join(path.relative_to(home.parent).with_suffix("").parts).removesuffix(".__init__")


@pytest.mark.parametrize("name", list(modules()))
def test_examples_hold(name):
    done = doctest.testmod(importlib.import_module(name))
    assert done.failed == 0
    assert done.attempted > 0
