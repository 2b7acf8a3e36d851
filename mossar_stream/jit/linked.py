"""Kernels that are compiled once and called by name.

numba copies every kernel into each kernel that calls it, and optimises the copy again. A large kernel at the
bottom of a deep stack is thus compiled a dozen times. One that is linked is compiled once for one signature;
its callers hold no more than its name, which is resolved when they are loaded. `publish` must therefore come
before the first call of any kernel that calls it.

What is not needed by everybody, as readers of frames are, is called by its address instead, which may come later.
"""

from collections.abc import Callable
from typing import Any

import numba

from mossar_stream.jit import linked_calls
from mossar_stream.jit.cache import open_cache
from mossar_stream.jit.decorators import entry_point
from mossar_stream.jit.linked_calls import callable_by_name, make_known

_kernels: dict[str, tuple[Any, Any]] = {}  # by name: kernel, signature or type of the result
_published: set[tuple[str, tuple[Any, ...]]] = set()


def linked(name: str, signature: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let a kernel be called by name (decorator). Only kernels can call the result.

    Args:
        name: Unique in the process.
        signature: Types of result and arguments, as numba writes them; only that of the result for a kernel that
            is compiled for every kind of arguments it is called with. Callers pass arguments of these very types.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        kernel: Any = function if hasattr(function, "py_func") else entry_point(function)
        _kernels[name] = kernel, signature
        return callable_by_name(name, kernel, signature)

    return decorate


def publish(name: str, *arguments: Any) -> None:
    """Make a linked kernel callable: compile it, or load it from the cache.

    Args:
        name: Of the kernel.
        *arguments: Values like those it is called with, if it was not made for one signature.
    """
    kernel, signature = _kernels[name]
    types = tuple(map(numba.typeof, arguments)) or signature.args
    if (name, types) in _published:
        return
    open_cache()
    kernel.compile(types)
    make_known(name, kernel, types)
    _published.add((name, types))


def address_of(kernel: Any, signature: Any) -> int:
    """Return the address by which kernels call an entry point of a signature: compile it, or load it from the cache."""
    if signature.args not in kernel.overloads:
        open_cache()
        kernel.compile(signature.args)
    return linked_calls.address_of(kernel, signature.args)
