"""Eight cells as one value of a kernel: LLVM does not find that eight stores side by side are one."""

from llvmlite import ir
from numba import types

from ppaas.planners.kernels.intrinsics import ARRAY, operation

AT_ONCE = 8

_WORD, _PLACE = ir.IntType(64), ir.IntType(32)
_CELLS = ir.VectorType(_WORD, AT_ONCE)


@operation(types.none, ARRAY, types.intp, types.int64, ARRAY, types.intp)
def write_next(
    builder: ir.IRBuilder, flat: ir.Value, at: ir.Value, cell: ir.Value, steps: ir.Value, first: ir.Value
) -> None:
    """Write a cell plus each of eight steps, from ``at`` and ``first`` on; int64 arrays, no look at their ends."""
    nothing = ir.Constant(_CELLS, ir.Undefined)
    lowest = builder.insert_element(nothing, cell, ir.Constant(_PLACE, 0))
    begin = builder.shuffle_vector(lowest, nothing, ir.Constant(ir.VectorType(_PLACE, AT_ONCE), [0] * AT_ONCE))
    next_ = builder.load(builder.bitcast(builder.gep(steps, [first]), _CELLS.as_pointer()))
    next_.align = 8
    builder.store(builder.add(begin, next_), builder.bitcast(builder.gep(flat, [at]), _CELLS.as_pointer())).align = 8
