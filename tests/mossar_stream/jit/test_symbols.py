"""Kernels of several processes never have the same name in machine code unless they are the same."""

import os
import subprocess
import sys

MODULE = """
import numpy as np
from mossar_stream.jit.decorators import entry_point, kernel

TALL = np.dtype([("above", "f8"), ("value", "f8")])
WIDE = np.dtype([("value", "f8"), ("left", "f8"), ("right", "f8")])

@kernel
def value_of(records):  # too long to be copied into its caller
    a = b = c = d = 1.0
    for record in records:
        a = np.sin(a + record.value) + np.cos(b) * np.exp(-c * c) + np.hypot(a, d)
        b = np.sin(b + record.value) + np.cos(c) * np.exp(-d * d) + np.hypot(b, a)
        c = np.sin(c + record.value) + np.cos(d) * np.exp(-a * a) + np.hypot(c, b)
        d = np.sin(d + record.value) + np.cos(a) * np.exp(-b * b) + np.hypot(d, c)
    return records[0].value + 0.0 * (a + b + c + d)

@entry_point
def double(records):
    return 2.0 * value_of(records)

def doubled(dtype):
    records = np.zeros(1, dtype)
    records["value"] = 21.0
    return double(records)
"""


def run(folder, program):
    """Run a program that finds the module, with the cache of kernels in a folder, and return what it prints."""
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(folder / "kernels"),
        "PYTHONPATH": os.pathsep.join([str(folder), *sys.path]),
    }
    done = subprocess.run(
        [sys.executable, "-c", f"from module import *\n{program}"],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.split()


def test_kernels_that_two_processes_compiled_for_other_records_are_told_apart_in_a_third(tmp_path):
    (tmp_path / "module.py").write_text(MODULE)
    (tmp_path / "kernels").mkdir()
    open_here = "from mossar_stream.jit.cache import open_cache; open_cache();"
    # Each meets its record first, so that numba gives both the same number.
    assert run(tmp_path, open_here + "print(doubled(TALL))") == ["42.0"]
    assert run(tmp_path, open_here + "print(doubled(WIDE))") == ["42.0"]
    third = open_here + "print(doubled(TALL), doubled(WIDE), sum(double.stats.cache_hits.values()))"
    assert run(tmp_path, third) == ["42.0", "42.0", "2"]


def test_the_name_of_a_kernel_does_not_depend_on_what_the_process_met_before(tmp_path):
    (tmp_path / "module.py").write_text(MODULE)
    name = "doubled(WIDE); print(*[one.fndesc.mangled_name for one in double.overloads.values()])"
    first = run(tmp_path, name)
    others = "import numba; [numba.typeof(np.zeros(1, [(f'f{i}', 'f8')])) for i in range(50)]\n"
    assert run(tmp_path, others + name) == first
    assert first != run(tmp_path, name.replace("WIDE", "TALL"))
