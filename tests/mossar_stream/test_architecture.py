"""What docs/architecture.md says of the core is there, under that name."""

import importlib
import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "architecture.md").read_text()
ROOMS = "algorithm|engine|following|jit|memory|moves|poses|readers|repetitions|segmenter|similarity|steps"
NAMES = sorted(set(re.findall(rf"`((?:{ROOMS})\.[a-zA-Z_.]+)`", PAGE[PAGE.index("## One push") :])))


@pytest.mark.parametrize("name", NAMES)
def test_every_step_of_a_push_is_where_the_page_says(name):
    *home, last = ("mossar_stream." + name).split(".")
    try:
        importlib.import_module(".".join([*home, last]))
    except ModuleNotFoundError:
        try:
            assert hasattr(importlib.import_module(".".join(home)), last)
        except ModuleNotFoundError:
            *home, kind = home
            assert hasattr(getattr(importlib.import_module(".".join(home)), kind), last)


def test_steps_are_named():
    assert len(NAMES) > 12
