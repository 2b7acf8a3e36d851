"""A version of numba that was never tested is named, with what to install instead."""

import warnings

import numba
import pytest

from mossar_stream.jit.numba_versions import is_tested, warn_if_untested


@pytest.mark.parametrize("version", ["0.60.0", "0.61.2", "0.68.1", numba.__version__])
def test_tested_versions_are_passed_over_in_silence(version):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_if_untested(version)
    assert is_tested(version)


@pytest.mark.parametrize("version", ["0.59.1", "0.69.0", "0.69.0dev0+1.gabc", "1.0.0", "unknown"])
def test_another_version_is_named_with_what_to_install(version):
    with pytest.warns(RuntimeWarning, match=r"pip install 'numba>=0\.60,<0\.69'") as warned:
        warn_if_untested(version)
    assert f"this is {version};" in str(warned[0].message)
