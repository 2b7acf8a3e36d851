"""Which way kernels are compiled: accelerated or plain. Both give the same results, bit by bit.

The plain path uses what numba documents and nothing else; it works with every numba. The accelerated one reaches
into numba's private parts so that kernels compile in less time and frames take less: inner kernels without machine
code (`inner`), kernels called by name (`linked`), instructions written by hand (`instructions`), no counting of
references, a cache that survives damage (`cache.SturdyCache`). A numba that lacks one of these parts, or in which
one of them means something else, is noticed by a trial on small kernels, and everything is compiled plainly.
"""

import functools
from importlib import import_module

from mossar_stream.jit import cache

_forced: list[bool] = []


def force_plain_path() -> None:
    """Let this process compile kernels plainly, whatever would work; for tests of that path.

    Raises:
        RuntimeError: If kernels have been declared already.
    """
    if is_accelerated.cache_info().currsize and is_accelerated():
        raise RuntimeError("the plain path must be chosen before the first kernel is imported")
    _forced.append(True)


@functools.cache
def is_accelerated() -> bool:
    """Tell whether kernels of this process are compiled on the accelerated path."""
    if _forced:
        return False
    # A folder of accelerated kernels is made only by a process whose trial succeeded, in the same environment.
    return cache.exists(accelerated=True) or _trial_succeeds()


def open_own_cache() -> cache.Cache:
    """Open the cache of the path of this process; before the first entry point is compiled, or it would not be kept.

    Raises:
        MossarError: If nothing can be written anywhere.
    """
    return cache.open_cache(accelerated=is_accelerated())


def _trial_succeeds() -> bool:
    try:
        return bool(import_module("mossar_stream.jit.trial").succeeds())
    except Exception:  # noqa: BLE001 - private parts that have changed fail in any way
        return False
