"""What is installed: the three packages with their types, and no check."""

import re
import tarfile
import zipfile
from pathlib import Path

import pytest

from build_core.extensions import variants
from build_core.sources import sources

ROOT = Path(__file__).parents[1]
PACKAGES = {"mossar_stream", "mossar_adapters", "mossar_tools"}


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    builders = pytest.importorskip("hatchling.builders.wheel", reason="hatchling is not installed")
    folder = tmp_path_factory.mktemp("wheel")
    path = next(builders.WheelBuilder(str(ROOT)).build(directory=str(folder)))
    with zipfile.ZipFile(path) as wheel:
        return wheel.namelist()


def test_the_wheel_holds_the_three_packages_and_no_check(names):
    tops = {name.partition("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == PACKAGES
    assert not [name for name in names if "checks" in name or "tests" in name]
    assert {f"{package}/py.typed" for package in PACKAGES} <= set(names)


def test_the_core_is_in_it_without_its_sources(names):
    core = [name for name in names if name.endswith((".so", ".pyd"))]
    assert "mossar_stream/core/baseline" in {name.partition(".")[0] for name in core}
    assert len(core) == len(variants())
    assert not [name for name in names if name.endswith((".pyx", ".pxi", ".pxd", ".h", ".c"))]


def test_the_sdist_holds_what_compiles_the_core(tmp_path):
    builders = pytest.importorskip("hatchling.builders.sdist", reason="hatchling is not installed")
    path = next(builders.SdistBuilder(str(ROOT)).build(directory=str(tmp_path)))
    with tarfile.open(path) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    hook = {path.relative_to(ROOT).as_posix() for path in (ROOT / "tools" / "build_core").glob("*.py")}
    assert {path.relative_to(ROOT).as_posix() for path in sources()} | hook <= names
    assert not [name for name in names if name.endswith((".so", ".pyd", ".c"))]


def test_nothing_that_is_installed_imports_a_check():
    for home in ("mossar_stream", "adapters/mossar_adapters", "tools/mossar_tools"):
        for path in (ROOT / home).rglob("*.py"):
            assert not re.search(r"^\s*(?:from|import) checks\b", path.read_text(), re.MULTILINE), path


def test_every_module_is_in_it(names):
    for home in ("mossar_stream", "adapters/mossar_adapters", "tools/mossar_tools"):
        parent = (ROOT / home).parent
        sources = {path.relative_to(parent).as_posix() for path in (ROOT / home).rglob("*.py")}
        assert sources <= set(names)
