"""Kernel parts: where an array lies, and the array that lies somewhere, for threads that are told of it by numbers."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import NDArray

from ppaas.planners.kernels.simd import ARRAY, number, operation

Int = int | np.signedinteger[Any]


@operation(number, ARRAY)
def address_of(builder: ir.IRBuilder, data: ir.Value) -> ir.Value:
    """Return the address of the first element of an array."""
    return builder.ptrtoint(data, ir.IntType(64))


def _array_at(element: Any, readonly: bool = False) -> Any:
    kind = types.Array(element, 1, "C", readonly=readonly)

    def at(_typing: Any, _address: Any, _count: Any) -> Any:
        def emit(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
            made = context.make_array(kind)(context, builder)
            size = context.get_constant(types.intp, element.bitwidth // 8)
            populate_array(  # type: ignore[no-untyped-call]
                made,
                data=builder.inttoptr(arguments[0], made.data.type),
                shape=[arguments[1]],
                strides=[size],
                itemsize=size,
                meminfo=None,
            )
            return made._getvalue()

        return kind(number, number), emit

    return intrinsic(at)


octets_at = cast("Callable[[Int, Int], NDArray[np.uint8]]", _array_at(types.uint8))
"""Return the array of so many uint8 from an address on: whoever calls sees to it that they stay there."""
map_at = cast("Callable[[Int, Int], NDArray[np.uint8]]", _array_at(types.uint8, readonly=True))
"""The same, of one that nobody writes to."""
numbers_at = cast("Callable[[Int, Int], NDArray[np.uint32]]", _array_at(types.uint32))
"""The same, of uint32."""
longs_at = cast("Callable[[Int, Int], NDArray[np.int64]]", _array_at(types.int64))
"""The same, of int64."""
