"""Kernel parts: arrays given by two int64 numbers, their address and length.

The code that writes the numbers must keep the array alive.
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import NDArray

from ppaas.planners.kernels.intrinsics import ARRAY, number, operation

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]


@operation(number, ARRAY)
def address_of(builder: ir.IRBuilder, data: ir.Value) -> ir.Value:
    """Return the address of the first element of an array."""
    return builder.ptrtoint(data, ir.IntType(64))


def _array_of(element: Any, readonly: bool = False) -> Any:
    kind = types.Array(element, 1, "C", readonly=readonly)

    def of(_typing: Any, _record: Any, _place: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            record = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            address = builder.gep(record, [arguments[1]])
            made = context.make_array(kind)(context, builder)
            size = context.get_constant(types.intp, element.bitwidth // 8)
            populate_array(  # type: ignore[no-untyped-call]
                made,
                data=builder.inttoptr(builder.load(address), made.data.type),
                shape=[builder.load(builder.gep(address, [ir.IntType(64)(1)]))],
                strides=[size],
                itemsize=size,
                meminfo=None,
            )
            return made._getvalue()

        return kind(_record, number), emit

    return intrinsic(of)


bytes_of = cast("Callable[[Ints, Int], NDArray[np.uint8]]", _array_of(types.uint8))
"""Return the uint8 array whose address and length are at an index of an int64 array."""
readonly_bytes_of = cast("Callable[[Ints, Int], NDArray[np.uint8]]", _array_of(types.uint8, readonly=True))
"""The same for a read-only uint8 array."""
uint32s_of = cast("Callable[[Ints, Int], NDArray[np.uint32]]", _array_of(types.uint32))
"""The same for a uint32 array."""
int64s_of = cast("Callable[[Ints, Int], NDArray[np.int64]]", _array_of(types.int64))
"""The same for an int64 array."""
