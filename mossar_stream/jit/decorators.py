"""How kernels are declared: compiled by numba, without the interpreter lock, cached on disk.

    kernel         what other kernels call
    inline_kernel  the same, copied into its callers: for what every frame goes through
    entry_point    what Python calls

Nothing is compiled before it is first called.
"""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar, cast, overload

import numba
import numba.extending

from mossar_stream.errors import MossarError
from mossar_stream.jit.cache import cached
from mossar_stream.jit.options import entry_options, inner_options
from mossar_stream.jit.symbols import name_records_by_contents

F = TypeVar("F", bound=Callable[..., object])

if cast("Any", numba.config).DISABLE_JIT:
    raise MossarError("NUMBA_DISABLE_JIT is set, but the kernels cannot run uncompiled; unset it")
name_records_by_contents()


@overload
def kernel(function: F) -> F: ...


@overload
def kernel(*, chosen_by: Callable[..., Callable[..., object]]) -> Callable[[F], F]: ...


def kernel(
    function: F | None = None, *, chosen_by: Callable[..., Callable[..., object]] | None = None
) -> F | Callable[[F], F]:
    """Compile a function that only other kernels call (decorator); to call it from Python is an error.

    Args:
        function: The kernel.
        chosen_by: Makes the kernel a stub, which is compiled as whatever this returns for the stub's name and the numba
            types of the arguments: a Python function with the same parameters. For the protocol of similarity measures,
            so that using one does not compile the others.
    """
    if chosen_by is not None:
        return lambda stub: _chosen_kernel(stub, chosen_by)
    return cast("F", numba.njit(**inner_options())(function))


def _chosen_kernel(stub: F, choose: Callable[..., Callable[..., object]]) -> F:
    def chosen(*types: Any) -> Callable[..., object]:
        return choose(stub.__name__, *types)

    chosen.__signature__ = inspect.signature(stub)  # type: ignore[attr-defined]
    options: Any = inner_options()
    numba.extending.overload(stub, jit_options=options)(chosen)
    return stub


@overload
def inline_kernel(function: F) -> F: ...


@overload
def inline_kernel(*, returns_views: bool) -> Callable[[F], F]: ...


def inline_kernel(function: F | None = None, *, returns_views: bool = False) -> F | Callable[[F], F]:
    """Compile a kernel that is copied into those that call it (decorator).

    For what every frame goes through: an array is handed over as seven words on the stack, so that a call costs as
    much as a pass over the joints. A long one with several callers is better left to be called.

    Args:
        function: The kernel.
        returns_views: True if it returns arrays that it has not been given, as `part` makes them: kernels that count
            no references cannot return those, so numba copies the lines of such a kernel into its callers.
    """
    if function is None:
        return lambda own: _inline_kernel(own, returns_views=returns_views)
    return _inline_kernel(function, returns_views=returns_views)


def _inline_kernel(function: F, *, returns_views: bool) -> F:
    options = inner_options(inline=True, returns_views=returns_views)
    return cast("F", numba.njit(**options)(function))


@overload
def entry_point(function: F) -> F: ...


@overload
def entry_point(*, makes_arrays: bool) -> Callable[[F], F]: ...


def entry_point(function: F | None = None, *, makes_arrays: bool = True) -> F | Callable[[F], F]:
    """Compile a kernel that Python calls, on its first call, and cache it on disk (decorator).

    Args:
        function: The kernel.
        makes_arrays: False if neither it nor any kernel that it calls makes an array, but for those called by name
            (`linked.py`). Then nobody need count references to arrays, which costs frames a fifth of their time.
    """
    if function is None:
        return lambda own: _entry_point(own, makes_arrays=makes_arrays)
    return _entry_point(function, makes_arrays=makes_arrays)


def _entry_point(function: F, *, makes_arrays: bool) -> F:
    options = entry_options(makes_arrays=makes_arrays)
    return cast("F", cached(numba.njit(**options)(function)))
