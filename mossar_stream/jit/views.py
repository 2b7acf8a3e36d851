"""How compiled code looks at a row of bytes as numbers and records."""

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
        sizes = [
            context.cast(builder, size, own, types.intp)
            for size, own in zip(cgutils.unpack_tuple(builder, values[3]), signature.args[3], strict=True)
        ]
        item = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        strides = [context.get_constant(types.intp, item)]
        for size in sizes[:0:-1]:
            strides.insert(0, builder.mul(strides[0], size))
        array = make_array(found)(context, builder)
        pointer = builder.bitcast(data, array.data.type)
        populate_array(array, pointer, sizes, strides, item, meminfo=None)
        return array._getvalue()  # noqa: SLF001 - numba's own way to end

    return found(memory, begin, kind, shape), generate
