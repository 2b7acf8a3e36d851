"""Kernels that stand apart: compiled once, called by name.

numba copies every kernel into each kernel that calls it, and optimises the copy again. A large kernel at the
bottom of a deep stack is thus compiled a dozen times. One that stands apart is compiled once for one signature;
its callers hold no more than its name, which is resolved when they are loaded. `publish` must therefore come
before the first call of any kernel that calls it.
"""

import hashlib
import inspect
from collections.abc import Callable
from typing import Any, cast

import llvmlite.binding
import numba
import numba.core.cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

from mossar_stream.jit.decorators import entry_point

_llvm: Any = numba.core.cgutils
_kernels: dict[str, tuple[Any, Any]] = {}  # by name: kernel, signature or type of the result
_published: set[str] = set()


def apart(name: str, signature: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let a kernel stand apart (decorator). Only kernels can call the result.

    Args:
        name: Unique in the process.
        signature: Types of result and arguments, as numba writes them; only that of the result for a kernel that
            is compiled for every kind of arguments it is called with.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        kernel: Any = function if hasattr(function, "py_func") else entry_point(function)
        _kernels[name] = kernel, signature

        def resolve(_context: Any, *arguments: Any) -> Any:
            if isinstance(signature, numba.types.Type):
                own = signature(*arguments)
                if _full_name(name, own.args) not in _published:  # a call would crash
                    raise TypingError(f"{name} was not published for {own.args}")
                return own, _call(_full_name(name, own.args), own)
            return signature, _call(_full_name(name, signature.args), signature)

        own = inspect.signature(kernel.py_func)
        context = inspect.Parameter("context", inspect.Parameter.POSITIONAL_ONLY)
        resolve.__signature__ = own.replace(parameters=[context, *own.parameters.values()])  # type: ignore[attr-defined]
        return cast("Callable[..., Any]", intrinsic(resolve))

    return decorate


def _full_name(name: str, types: tuple[Any, ...]) -> str:
    """Return the name under which a kernel for these arguments is found."""
    return f"{name}.{hashlib.sha256(repr(types).encode()).hexdigest()[:16]}"


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


def publish(name: str, *arguments: Any) -> None:
    """Make a kernel that stands apart callable: compile it, or load it from the cache.

    Args:
        name: Of the kernel.
        *arguments: Values like those it is called with, if it was not made for one signature.
    """
    kernel, signature = _kernels[name]
    types = tuple(map(numba.typeof, arguments)) or signature.args
    full = _full_name(name, types)
    if full in _published:
        return
    kernel.compile(types)
    result = kernel.overloads[types]
    address = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    llvmlite.binding.add_symbol(full, int(address))
    _published.add(full)
