"""A numba without the private parts that acceleration stands on compiles the same kernels plainly."""

import subprocess
import sys

import pytest

from mossar_stream.jit import trial

KERNELS = """
import sys
import numpy as np
from numba import float64
from mossar_stream.jit.acceleration import force_plain_path, is_accelerated
{prepare}
from mossar_stream.jit import simd, simd_twin
from mossar_stream.jit.decorators import entry_point, inline_kernel, kernel
from mossar_stream.jit.linked import linked, publish
from mossar_stream.jit.views import part

RECORD = np.dtype([("step", "f8"), ("count", "i8")])

@linked("test.total", float64(float64[::1]))
def total(values):
    return values.sum()

@kernel
def count(record, by):
    record.count += by
    return record.step

@inline_kernel(returns_views=True)
def record_at(memory, begin):
    return part(memory, begin, RECORD, (1,))

@entry_point(makes_arrays=False)
def all_at_once(memory, page, values):
    record = record_at(memory, 8)[0]
    return count(record, 3) + total(values) + simd.page_sum(page, 32), record.count

memory, page, values = np.zeros(40, np.uint8), np.arange(64, dtype=np.float32) / 7, np.arange(5.0)
memory[8:24].view(RECORD)["step"] = 0.25
publish("test.total")
found, counted = all_at_once(memory, page, values)
assert (found, counted) == (0.25 + 10.0 + simd_twin.page_sum(page, 32), 3), (found, counted)
print("accelerated" if is_accelerated() else "plain")
"""
FORCED = "force_plain_path()"
MISSING = "import {module}\ndel {module}.{name}\nfrom mossar_stream.jit import cache\ncache.exists = lambda **_: False"
CHANGED = (
    "import mossar_stream.jit.instructions as own\nown.page_sum = own.page_within\n"
    "from mossar_stream.jit import cache\ncache.exists = lambda **_: False"
)


def path_taken(prepare):
    done = subprocess.run(
        [sys.executable, "-c", KERNELS.format(prepare=prepare)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_the_trial_succeeds_with_this_numba():
    assert trial.succeeds()


def test_the_plain_path_can_be_forced():
    assert path_taken(FORCED) == "plain"


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("numba.core.codegen", "CPUCodeLibrary"),
        ("numba.core.typed_passes", "NativeLowering"),
    ],
)
def test_a_private_part_that_is_gone_costs_time_only(module, name):
    assert path_taken(MISSING.format(module=module, name=name)) == "plain"


def test_a_private_part_that_means_something_else_costs_time_only():
    assert path_taken(CHANGED) == "plain"
