"""Kernel: tell the CPU which memory is looked at soon, so that it comes while other work is done."""

from collections.abc import Callable
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

LINE = 16
"""Numbers of 32 bits that memory brings at once."""

WORDS_A_LINE = LINE // 2
"""Numbers of 64 bits, likewise."""
OCTETS_A_LINE = 4 * LINE
"""Numbers of 8 bits."""

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
"""Begin to bring what lies at an index of an array; nothing happens where that is outside of all memory."""
fetch_close = _fetching(_SECOND)
"""The same, but only as far as the second cache, where far more lines that lie a power of two apart have room."""
