"""Missing libraries are answered with the line that installs them here; extras of users bring what exists."""

import os
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from mossar_adapters.extras import install_line, needed
from mossar_stream import MossarError

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]


class Installed:
    def __init__(self, installer):
        self._installer = installer

    def read_text(self, _):
        return self._installer


@pytest.mark.skipif(os.name == "nt", reason="Windows has other quotes")
@pytest.mark.parametrize(
    ("installer", "prefix", "line"),
    [
        ("pip\n", "/usr", "pip install 'mossar-stream[web]'"),
        (None, "/usr", "pip install 'mossar-stream[web]'"),
        ("uv\n", "/usr", "uv pip install 'mossar-stream[web]'"),
        (
            "pip\n",
            "/home/a/.local/pipx/venvs/mossar-stream",
            "pipx inject mossar-stream 'mossar-stream[web]'",
        ),
    ],
)
def test_the_program_that_installed_it_is_named(monkeypatch, installer, prefix, line):
    monkeypatch.setattr(metadata, "distribution", lambda _: Installed(installer))
    monkeypatch.setattr(sys, "prefix", prefix)
    assert install_line("web") == line
    with pytest.raises(MossarError, match=r"the page needs an extra: .*mossar-stream\[web\]"):
        needed("there_is_no_such_library", "web", "the page")


def test_a_checkout_that_is_not_installed_is_named_by_its_folder(monkeypatch):
    def none(_):
        raise metadata.PackageNotFoundError

    monkeypatch.setattr(metadata, "distribution", none)
    line = install_line("web")
    assert f"{ROOT}[web]" in line or "mossar-stream[web]" in line
    assert line.startswith("pip install ")


def test_extras_for_users_name_extras_that_exist():
    for name in ("game", "exercise", "research", "scripts", "all"):
        (own,) = EXTRAS[name]
        parts = own.removeprefix("mossar-stream[").removesuffix("]").split(",")
        assert set(parts) <= set(EXTRAS)
        assert parts == sorted(parts)
    left_out = {"flink", "archive", "peers", "game", "exercise", "research", "scripts", "all"}
    assert set(EXTRAS["all"][0].removeprefix("mossar-stream[").removesuffix("]").split(",")) == (
        set(EXTRAS) - left_out
    )
