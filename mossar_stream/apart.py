"""Kernels that stand apart: compiled once, called by name.

numba copies every kernel into each kernel that calls it, and optimises the copy again. A large kernel at the
bottom of a deep stack is thus compiled a dozen times. One that stands apart is compiled once for one signature;
its callers hold no more than its name, which is resolved when they are loaded. `publish` must therefore come
before the first call of any kernel that calls it.
"""

import inspect
from collections.abc import Callable
from typing import Any, cast

import llvmlite.binding
import numba.core.cgutils
from numba.extending import intrinsic

from mossar_stream.compiled import entry_point

_llvm: Any = numba.core.cgutils
_compile: dict[str, Callable[[], int]] = {}  # by name: compiles the kernel and returns its address
_published: set[str] = set()


def apart(name: str, signature: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let a kernel stand apart (decorator). Only kernels can call the result.

    Args:
        name: Unique in the process.
        signature: Types of result and arguments, as numba writes them.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        kernel: Any = entry_point(function)

        def resolve(_context: Any, *_arguments: Any) -> Any:
            return signature, _call(name, signature)

        own = inspect.signature(function)
        context = inspect.Parameter("context", inspect.Parameter.POSITIONAL_ONLY)
        resolve.__signature__ = own.replace(parameters=[context, *own.parameters.values()])  # type: ignore[attr-defined]
        _compile[name] = lambda: _address(kernel, signature)
        return cast("Callable[..., Any]", intrinsic(resolve))

    return decorate


def _call(name: str, signature: Any) -> Callable[..., Any]:
    """Return what generates a call by name, as numba calls its own functions."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kinds = signature.return_type, signature.args
        target = _llvm.get_or_insert_function(
            builder.module, context.call_conv.get_function_type(*kinds), name
        )
        status, result = context.call_conv.call_function(builder, target, *kinds, arguments)
        with _llvm.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return result

    return generate


def _address(kernel: Any, signature: Any) -> int:
    """Compile a kernel, or load it from the cache, and return where it lies."""
    kernel.compile(signature)
    result = kernel.overloads[tuple(signature.args)]
    return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))


def publish(*names: str) -> None:
    """Make kernels that stand apart callable: compile them, or load them from the cache."""
    for name in names:
        if name not in _published:
            llvmlite.binding.add_symbol(name, _compile[name]())
            _published.add(name)
