"""SIMD intrinsic that writes eight cells at once: LLVM does not merge eight adjacent stores into one."""

from llvmlite import ir
from numba import types

from ppaas.planners.kernels.intrinsics import ARRAY, operation

AT_ONCE = 8
"""Cells per store."""

_WORD, _PLACE = ir.IntType(64), ir.IntType(32)
_CELLS = ir.VectorType(_WORD, AT_ONCE)


@operation(types.none, ARRAY, types.intp, types.int64, ARRAY, types.intp)
def write_next(
    builder: ir.IRBuilder, flat: ir.Value, at: ir.Value, cell: ir.Value, steps: ir.Value, first: ir.Value
) -> None:
    """Store ``cell`` plus eight steps, read from ``first``, at index ``at``; int64 arrays, without bounds checks."""
    nothing = ir.Constant(_CELLS, ir.Undefined)
    lowest = builder.insert_element(nothing, cell, ir.Constant(_PLACE, 0))
    begin = builder.shuffle_vector(lowest, nothing, ir.Constant(ir.VectorType(_PLACE, AT_ONCE), [0] * AT_ONCE))
    next_ = builder.load(builder.bitcast(builder.gep(steps, [first]), _CELLS.as_pointer()))
    next_.align = 8
    builder.store(builder.add(begin, next_), builder.bitcast(builder.gep(flat, [at]), _CELLS.as_pointer())).align = 8
