"""Compiled kernels stay valid until an edit changes what they are compiled from."""

import os
import shutil
import subprocess
import sys

import pytest

from mossar_stream.jit.sources import PACKAGE, digest


@pytest.fixture
def package(tmp_path):
    """Return a copy of the package's sources."""
    copy = tmp_path / "package"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def edited(package, source, old, new):
    """Return the name after one edit, which is then undone."""
    path = package / source
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    found = digest(package)
    path.write_text(text)
    return found


def test_a_copy_elsewhere_and_newer_files_have_the_same_name(package):
    for source in package.rglob("*.py"):
        os.utime(source, (0, 0))
    assert digest(package) == digest()


@pytest.mark.parametrize("seed", ["1", "2"])
def test_every_process_finds_the_same_name(seed):
    program = "from mossar_stream.jit.sources import digest; print(digest())"
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONHASHSEED": seed},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == digest()


@pytest.mark.parametrize(
    ("source", "old", "new"),
    [
        ("algorithm/splitter.py", '"""', '"""Edited. '),
        ("algorithm/splitter.py", "\nimport ", "\n# A comment of someone's.\n\nimport "),
        ("events.py", '"""', '"""Edited. '),
        ("segmenter/segmenter.py", "def push(", "def other(self): ...\n\n    def push("),
        ("recording/recording.py", "\nimport ", "\nNEW = 1\nimport "),
    ],
)
def test_comments_docstrings_and_modules_without_kernels_do_not_count(package, source, old, new):
    assert edited(package, source, old, new) == digest(package)


@pytest.mark.parametrize(
    ("source", "old", "new"),
    [
        ("algorithm/splitter.py", "\nimport ", "\nNEW = 1\nimport "),
        ("similarity/path_kernel/path_sum.py", "\nimport ", "\nNEW = 1.5\nimport "),
        ("similarity/summary.py", "\nimport ", "\nNEW = 1\nimport "),  # imported by modules with kernels
        ("jit/inner.py", "no_compile = True", "no_compile = False"),
    ],
)
def test_code_and_constants_of_kernels_count(package, source, old, new):
    assert edited(package, source, old, new) != digest(package)


def test_a_new_module_counts_as_soon_as_it_holds_a_kernel(package):
    before = digest(package)
    new = package / "similarity" / "path_kernel" / "new.py"
    new.write_text("A = 1\n")
    assert digest(package) == before
    new.write_text("from mossar_stream.jit.decorators import kernel\n\n@kernel\ndef f(x):\n    return x\n")
    assert digest(package) != before
