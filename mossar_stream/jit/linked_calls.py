"""How a kernel is called by name: a piece of numba's private parts that `linked` stands on."""

import hashlib
import inspect
from collections.abc import Callable
from typing import Any, cast

import llvmlite.binding
import numba
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

_llvm: Any = cgutils
_known: set[str] = set()  # full names


def callable_by_name(name: str, kernel: Any, signature: Any) -> Callable[..., Any]:
    """Return what kernels call instead of a kernel."""

    def resolve(_context: Any, *arguments: Any) -> Any:
        if isinstance(signature, numba.types.Type):
            own = signature(*arguments)
            if full_name(name, own.args) not in _known:  # a call would crash
                raise TypingError(f"{name} was not published for {own.args}")
            return own, _call(full_name(name, own.args), own)
        return signature, _call(full_name(name, signature.args), signature)

    own = inspect.signature(kernel.py_func)
    context = inspect.Parameter("context", inspect.Parameter.POSITIONAL_ONLY)
    resolve.__signature__ = own.replace(parameters=[context, *own.parameters.values()])  # type: ignore[attr-defined]
    return cast("Callable[..., Any]", intrinsic(resolve))


def full_name(name: str, types: tuple[Any, ...]) -> str:
    """Return the name under which a kernel for these arguments is found."""
    return f"{name}.{hashlib.sha256(repr(types).encode()).hexdigest()[:16]}"


def _call(name: str, signature: Any) -> Callable[..., Any]:
    """Return what generates a call by name, as numba calls its own functions."""

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = context.call_conv.get_function_type(signature.return_type, signature.args)
        target = _llvm.get_or_insert_function(builder.module, kind, name)
        return _call_function(context, builder, target, signature, arguments)

    return generate


def callable_at_address(signature: Any) -> Callable[..., Any]:
    """Return what kernels call with an address before the arguments: the kernel of this signature that lies there."""

    def resolve(_context: Any, address: Any, arguments: Any) -> Any:
        def generate(context: Any, builder: Any, _own: Any, values: Any) -> Any:
            kind = context.call_conv.get_function_type(signature.return_type, signature.args)
            target = builder.inttoptr(values[0], kind.as_pointer())
            own = _llvm.unpack_tuple(builder, values[1])
            return _call_function(context, builder, target, signature, own)

        return signature.return_type(numba.types.int64, arguments), generate

    return cast("Callable[..., Any]", intrinsic(resolve))


def _call_function(context: Any, builder: Any, target: Any, signature: Any, arguments: Any) -> Any:
    kinds = signature.return_type, signature.args
    status, result = context.call_conv.call_function(builder, target, *kinds, arguments)
    with _llvm.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return result


def address_of(kernel: Any, types: tuple[Any, ...]) -> int:
    """Return where a kernel that is compiled for arguments of these types lies."""
    compiled = kernel.overloads[types]
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))


def make_known(name: str, kernel: Any, types: tuple[Any, ...]) -> None:
    """Let LLVM find a kernel that is compiled for arguments of these types."""
    full = full_name(name, types)
    llvmlite.binding.add_symbol(full, address_of(kernel, types))
    _known.add(full)
