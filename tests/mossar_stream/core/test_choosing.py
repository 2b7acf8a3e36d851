"""Which core is used, and that none stands in for one that is missing or old."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from mossar_stream.core import choosing, kernels

STUB = Path(kernels.__file__).with_suffix(".pyi")


def tried(**variables):
    program = "from mossar_stream.core import kernels; print(kernels._core.__name__)"
    return subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_core_can_be_wished_for():
    assert tried(MOSSAR_CORE="baseline").stdout == "mossar_stream.core.baseline\n"
    if kernels.has_x86_64_v3() and not os.environ.get(choosing.WISH):
        assert tried(MOSSAR_CORE="").stdout == "mossar_stream.core.x86_64_v3\n"
    last = tried(MOSSAR_CORE="avx9").stderr.splitlines()[-1]
    assert last == "ImportError: MOSSAR_CORE=avx9: there are baseline and x86_64_v3"


def test_the_processor_is_known():
    try:
        flags = set(Path("/proc/cpuinfo").read_text().partition("flags")[2].partition("\n")[0].split())
    except FileNotFoundError:
        pytest.skip("there is no /proc/cpuinfo")
    wanted = {"avx2", "fma", "bmi1", "bmi2", "movbe", "f16c", "abm"}
    assert kernels.has_x86_64_v3() == (wanted <= flags)


def test_a_missing_core_names_the_command():
    with pytest.raises(ImportError, match=r"was not compiled for this Python: run `pip install -e \.`"):
        choosing._loaded("sse9")


def test_a_core_that_is_older_than_a_source_says_which(tmp_path, monkeypatch):
    monkeypatch.setattr(choosing, "HOME", str(tmp_path / "core"))
    (tmp_path / "core").mkdir()
    assert choosing._changed("mossar core cc 00000000\n352441c2 core/core.pxi\n") is None  # a wheel
    (tmp_path / "core" / "core.pxi").write_bytes(b"abc")
    assert choosing._changed("mossar core cc 00000000\n352441c2 core/core.pxi\n") is None
    (tmp_path / "core" / "core.pxi").write_bytes(b"abd")
    assert (
        choosing._changed("mossar core cc 00000000\n352441c2 core/core.pxi\n")
        == "mossar_stream/core/core.pxi"
    )
    assert (
        choosing._changed("mossar core cc 00000000\n352441c2 core/gone.pxi\n")
        == "mossar_stream/core/gone.pxi"
    )


def test_the_stub_says_what_the_core_offers():
    text = STUB.read_text()
    functions = set(re.findall(r"^(?:def|class) (\w+)", text, re.MULTILINE))
    constants = set(re.findall(r"^(\w+): (?!TypeAlias)", text, re.MULTILINE))
    offered = {name: value for name, value in vars(kernels).items() if name[0] != "_"}
    own = {
        name for name, value in offered.items() if getattr(value, "__module__", "") == kernels._core.__name__
    }
    assert functions == own
    assert constants == {"BUILT_FROM", "RECORDS", "CONSTANTS", "TESTED_CONSTANTS"} | {
        *kernels.CONSTANTS,
        *kernels.TESTED_CONSTANTS,
    }
