"""Kernels that only kernels call cannot be called from Python."""

import os
import subprocess
import sys

import pytest

from mossar_stream.jit.decorators import entry_point, kernel


@kernel
def doubled(x, y):
    return 2 * x + y


@entry_point
def doubled_and_one(x):
    return doubled(x, 1)


def test_an_inner_kernel_works_in_others_and_refuses_calls_from_python():
    assert doubled_and_one(4) == 9
    with pytest.raises(TypeError):
        doubled(4, 1)


def test_kernels_that_may_not_be_compiled_are_one_clear_error():
    program = "import mossar_stream\ntry:\n    mossar_stream.Segmenter\nexcept mossar_stream.MossarError as e:\n    print(e)"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "NUMBA_DISABLE_JIT is set, but the kernels cannot run uncompiled; unset it\n"
