"""Atomic operations on one element of an integer array.

All are sequentially consistent: all threads see the operations of all threads in one order. A thread that reads a value
by such an operation also sees everything that the writer had written before it. Elements are treated as unsigned.
"""

from typing import Any

from llvmlite import ir
from numba import types

from ppaas.planners.kernels.intrinsics import ARRAY, number, operation

_LONG = ir.IntType(64)
_ORDER = "seq_cst"


def _place(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> Any:
    return builder.gep(data, [index])


def _narrow(builder: ir.IRBuilder, value: ir.Value, data: ir.Value) -> ir.Value:
    return builder.trunc(value, data.type.pointee)


def _wide(builder: ir.IRBuilder, value: ir.Value) -> ir.Value:
    return builder.zext(value, _LONG)


@operation(number, ARRAY, types.intp)
def read(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> ir.Value:
    """Return an element."""
    octets = data.type.pointee.width // 8
    return _wide(builder, builder.load_atomic(_place(builder, data, index), _ORDER, octets))


@operation(types.none, ARRAY, types.intp, number)
def write(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> None:
    """Set an element."""
    octets = data.type.pointee.width // 8
    builder.store_atomic(_narrow(builder, value, data), _place(builder, data, index), _ORDER, octets)


@operation(types.boolean, ARRAY, types.intp, number, number)
def replace(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, expected: ir.Value, value: ir.Value) -> ir.Value:
    """Set an element if it has the expected value; return whether it had (compare-and-swap)."""
    values = (_narrow(builder, each, data) for each in (expected, value))
    return builder.extract_value(builder.cmpxchg(_place(builder, data, index), *values, _ORDER, _ORDER), 1)


def _combine(builder: ir.IRBuilder, how: str, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    return _wide(builder, builder.atomic_rmw(how, _place(builder, data, index), _narrow(builder, value, data), _ORDER))


@operation(number, ARRAY, types.intp, number)
def add(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    """Add to an element; return its previous value."""
    return _combine(builder, "add", data, index, value)


@operation(number, ARRAY, types.intp, number)
def lower(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    """Set an element to the minimum of itself and a number; return its previous value."""
    return _combine(builder, "umin", data, index, value)


@operation(number, ARRAY, types.intp, number)
def mark(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, bits: ir.Value) -> ir.Value:
    """Set bits of an element; return its previous value."""
    return _combine(builder, "or", data, index, bits)


@operation(types.none)
def fence(builder: ir.IRBuilder) -> None:
    """Prevent later reads from being reordered before earlier atomic operations; not needed on x86."""
    if not builder.module.triple.startswith("x86"):
        builder.fence(_ORDER)
