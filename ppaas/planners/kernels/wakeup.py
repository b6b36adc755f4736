"""Kernel parts: wake a thread that sleeps, and sleep until woken, without Python: a byte goes through a pipe.

What is compiled calls the C library itself, so neither needs the interpreter, for which threads of Python wait in turn.
"""

from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, get_or_insert_function

from ppaas.planners.kernels.intrinsics import number, operation

_OCTET, _INT, _LONG = (ir.IntType(bits) for bits in (8, 32, 64))


def _transfer(builder: ir.IRBuilder, how: str, pipe: ir.Value) -> None:
    kind = ir.FunctionType(_LONG, [_INT, _OCTET.as_pointer(), _LONG])
    function = get_or_insert_function(builder.module, kind, how)  # type: ignore[no-untyped-call]
    octet = alloca_once(builder, _OCTET)  # type: ignore[no-untyped-call]
    builder.store(_OCTET(1), octet)
    builder.call(function, [builder.trunc(pipe, _INT), octet, _LONG(1)])


@operation(types.none, number)
def hear(builder: ir.IRBuilder, pipe: ir.Value) -> None:
    """Sleep until a byte comes out of a pipe, or a signal wakes this thread."""
    _transfer(builder, "read", pipe)


@operation(types.none, number)
def ring(builder: ir.IRBuilder, pipe: ir.Value) -> None:
    """Put a byte into a pipe, unless it is full."""
    _transfer(builder, "write", pipe)


@operation(types.none, number)
def doze(builder: ir.IRBuilder, microseconds: ir.Value) -> None:
    """Sleep for a while, of less than a second."""
    kind = ir.FunctionType(_INT, [_INT])
    function = get_or_insert_function(builder.module, kind, "usleep")  # type: ignore[no-untyped-call]
    builder.call(function, [builder.trunc(microseconds, _INT)])
