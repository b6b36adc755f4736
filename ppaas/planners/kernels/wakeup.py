"""Kernel parts: sleep, and wake a sleeping thread by a byte through a pipe, without Python.

The compiled code calls the C library directly, so neither side needs the interpreter lock (GIL).
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
def wait_for_byte(builder: ir.IRBuilder, pipe: ir.Value) -> None:
    """Sleep until a byte can be read from a pipe, or a signal interrupts the thread."""
    _transfer(builder, "read", pipe)


@operation(types.none, number)
def send_byte(builder: ir.IRBuilder, pipe: ir.Value) -> None:
    """Write a byte to a pipe, unless it is full."""
    _transfer(builder, "write", pipe)


@operation(types.none, number)
def sleep(builder: ir.IRBuilder, microseconds: ir.Value) -> None:
    """Sleep for less than a second."""
    kind = ir.FunctionType(_INT, [_INT])
    function = get_or_insert_function(builder.module, kind, "usleep")  # type: ignore[no-untyped-call]
    builder.call(function, [builder.trunc(microseconds, _INT)])
