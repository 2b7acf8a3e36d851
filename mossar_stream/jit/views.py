"""How compiled code looks at bytes as numbers and records: at those of a row, or at those that lie at an address."""

from typing import Any

from numba import extending, types
from numba.core import cgutils
from numba.np.arrayobj import make_array, populate_array

intrinsic: Any = extending.intrinsic  # whose types hide the parameters from mypy


@intrinsic
def part(_context, memory, begin, kind, shape):
    """Return a part of an array's memory as another array; that it lies within is for the caller to see.

    Slices, `view` and `reshape` do the same, but look at everything twice: those that a row needs took as long as
    two frames.

    Args:
        _context: Given by the compiler.
        memory: Contiguous array.
        begin: Where in it the part begins, bytes.
        kind: Numpy type of the numbers, or of the records.
        shape: Tuple.
    """
    found = types.Array(kind.dtype, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole = make_array(signature.args[0])(context, builder, values[0])
        data = builder.gep(builder.bitcast(whole.data, cgutils.voidptr_t), [values[1]])
        return _array(context, builder, found, data, (signature.args[3], values[3]))

    return found(memory, begin, kind, shape), generate


@intrinsic
def at_address(_context, address, kind, shape):
    """Return what lies at an address as an array; that it lies there, and stays, is for the caller to see.

    Args:
        _context: Given by the compiler.
        address: Of the first byte, as `array.ctypes.data` has it.
        kind: Numpy type of the numbers, or of the records.
        shape: Tuple.
    """
    found = types.Array(kind.dtype, len(shape), "C")

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        data = builder.inttoptr(values[0], cgutils.voidptr_t)
        return _array(context, builder, found, data, (signature.args[2], values[2]))

    return found(types.int64, kind, shape), generate


def _array(context: Any, builder: Any, found: Any, data: Any, shape: tuple[Any, Any]) -> Any:
    """Generate an array of a type where its data lie; `shape` is the type and the value of the tuple."""
    kind, sizes = shape
    sizes = [
        context.cast(builder, size, own, types.intp)
        for size, own in zip(cgutils.unpack_tuple(builder, sizes), kind, strict=True)
    ]
    item = context.get_abi_sizeof(context.get_data_type(found.dtype))
    strides = [context.get_constant(types.intp, item)]
    for size in sizes[:0:-1]:
        strides.insert(0, builder.mul(strides[0], size))
    array = make_array(found)(context, builder)
    pointer = builder.bitcast(data, array.data.type)
    populate_array(array, pointer, sizes, strides, item, meminfo=None)
    return array._getvalue()  # noqa: SLF001 - numba's own way to end
