"""The versions of numba that kernels were tested with.

Kernels compile in less time, and run faster, because `jit` uses private parts of numba: inner kernels without machine
code (`inner`), kernels called by name (`linked_calls`), a cache that survives damage (`sturdy_cache`), names of record types
that mean the same in every process (`symbols`). A new version of numba may change any of them.
"""

import re
import warnings

OLDEST_TESTED, NEWEST_TESTED = (0, 60), (0, 68)  # tested; see also the comment in pyproject.toml


def is_tested(version: str) -> bool:
    """Tell whether a version of numba, such as "0.68.1", is within the tested range."""
    found = re.match(r"(\d+)\.(\d+)", version)
    return found is not None and OLDEST_TESTED <= (int(found[1]), int(found[2])) <= NEWEST_TESTED


def warn_if_untested(version: str) -> None:
    """Warn once, with what to install, if kernels were never tested with this version of numba."""
    if not is_tested(version):
        warnings.warn(
            f"mossar-stream was tested with numba {_text(OLDEST_TESTED)} to {_text(NEWEST_TESTED)}, and this is {version}; "
            f"if kernels do not compile, pip install 'numba>={_text(OLDEST_TESTED)},<{NEWEST_TESTED[0]}.{NEWEST_TESTED[1] + 1}'",
            RuntimeWarning,
            stacklevel=2,
        )


def _text(version: tuple[int, int]) -> str:
    return f"{version[0]}.{version[1]}"
