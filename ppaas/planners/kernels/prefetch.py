"""Kernel: prefetch instructions, which load memory into the cache while the CPU does other work."""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

LINE = 16
"""32-bit numbers in a cache line."""

WORDS_PER_LINE = LINE // 2
"""64-bit numbers in a cache line."""
BYTES_PER_LINE = 4 * LINE
"""Bytes in a cache line."""

Fetch = Callable[[NDArray[Any], Any], None]

_READ, _DATA = 0, 1
_NEAREST, _SECOND = 3, 2


def _fetching(into: int) -> Fetch:
    def fetch(_typing: Any, _array: Any, _index: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array = context.make_array(signature.args[0])(context, builder, arguments[0])
            number, to_bytes = ir.IntType(32), ir.IntType(8).as_pointer()
            pointer = builder.bitcast(builder.gep(array.data, [arguments[1]]), to_bytes)
            kind = ir.FunctionType(ir.VoidType(), [to_bytes, number, number, number])
            function = builder.module.declare_intrinsic("llvm.prefetch", (to_bytes,), kind)
            builder.call(function, [pointer, *(number(what) for what in (_READ, into, _DATA))])
            return context.get_dummy_value()

        return types.none(_array, types.int64), emit

    return cast("Fetch", intrinsic(fetch))


fetch = _fetching(_NEAREST)
"""Prefetch an element of an array into the first-level cache; an address outside of mapped memory is ignored."""
fetch_to_l2 = _fetching(_SECOND)
"""Prefetch an element into the second-level cache, which can hold more lines at power-of-two distances."""
