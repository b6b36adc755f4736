"""SIMD operations of kernels on a row of 32 unsigned 32-bit numbers.

numba has no vector types. Here a row is LLVM's ``<32 x i32>``, and each function below emits a few vector instructions.
LLVM splits them into the registers of the CPU: two of AVX-512, four of AVX2, eight of SSE2 or NEON. Sums wrap around;
comparisons are unsigned.

A set of lanes is an integer with one bit per lane; the lowest bit is lane 0.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import models, register_model

from ppaas.planners.kernels.intrinsics import ARRAY, number, operation

LANES = 32

_BIT, _OCTET, _NUMBER, _LONG = (ir.IntType(bits) for bits in (1, 8, 32, 64))
_ROW = ir.VectorType(_NUMBER, LANES)
_OCTETS = ir.VectorType(_OCTET, LANES)


class RowType(types.Type):
    """numba's type of a row."""

    def __init__(self) -> None:
        super().__init__(name="Row32")


row = RowType()
lanes = number


@register_model(RowType)
class _RowModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _ROW)  # type: ignore[no-untyped-call]


def _constant(values: list[int]) -> ir.Constant:
    return ir.Constant(ir.VectorType(_NUMBER, len(values)), values)


def _splat(builder: ir.IRBuilder, scalar: ir.Value) -> ir.Value:
    undefined = ir.Constant(_ROW, ir.Undefined)
    first = builder.insert_element(undefined, builder.trunc(scalar, _NUMBER), ir.Constant(_NUMBER, 0))
    return builder.shuffle_vector(first, undefined, _constant([0] * LANES))


def _pointer(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, to: ir.Type) -> ir.Value:
    return builder.bitcast(builder.gep(data, [index]), to.as_pointer())


def _bytes_compared(builder: ir.IRBuilder, how: str, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    loaded = builder.load(_pointer(builder, data, index, _OCTETS))
    loaded.align = 1
    undefined = ir.Constant(_OCTETS, ir.Undefined)
    first = builder.insert_element(undefined, builder.trunc(value, _OCTET), ir.Constant(_NUMBER, 0))
    values = builder.shuffle_vector(first, undefined, _constant([0] * LANES))
    return builder.zext(builder.bitcast(builder.icmp_unsigned(how, loaded, values), _NUMBER), _LONG)


def _least(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    return builder.select(builder.icmp_unsigned("<", a, b), a, b)


def _chosen(builder: ir.IRBuilder, chosen: ir.Value, yes: ir.Value, no: ir.Value) -> ir.Value:
    truths = builder.bitcast(builder.trunc(chosen, _NUMBER), ir.VectorType(_BIT, LANES))
    return builder.select(truths, yes, no)


@operation(row, ARRAY, types.intp)
def load(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> ir.Value:
    """Return the 32 numbers of a uint32 array from ``index`` on."""
    loaded = builder.load(_pointer(builder, data, index, _ROW))
    loaded.align = 4
    return loaded


@operation(number, ARRAY, types.intp)
def pick(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> ir.Value:
    """Return one number of a uint32 array, without numba's check for a negative index."""
    return builder.zext(builder.load(builder.gep(data, [index])), _LONG)


@operation(types.none, ARRAY, types.intp, number)
def put(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> None:
    """Write one number to a uint32 array, without that check."""
    builder.store(builder.trunc(value, _NUMBER), builder.gep(data, [index]))


@operation(row, ARRAY, types.intp)
def load_bytes(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> ir.Value:
    """Return the 32 numbers of a uint8 array from ``index`` on."""
    loaded = builder.load(_pointer(builder, data, index, _OCTETS))
    loaded.align = 1
    return builder.zext(loaded, _ROW)


@operation(row, ARRAY, types.intp)
def load_packed_bytes(builder: ir.IRBuilder, data: ir.Value, index: ir.Value) -> ir.Value:
    """Return the 128 numbers of a uint8 array from ``index`` on, four in each lane, in memory order."""
    loaded = builder.load(_pointer(builder, data, index, _ROW))
    loaded.align = 1
    return loaded


@operation(types.none, ARRAY, types.intp, row)
def store(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, values: ir.Value) -> None:
    """Write a row to a uint32 array from ``index`` on."""
    builder.store(values, _pointer(builder, data, index, _ROW)).align = 4


@operation(types.none, ARRAY, types.intp, row)
def stream(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, values: ir.Value) -> None:
    """Write a row past the caches (non-temporal store), at an index aligned to a cache line.

    The previous contents need not be loaded. Other threads see it after the next atomic operation of this thread.
    """
    written = builder.store(values, _pointer(builder, data, index, _ROW))
    written.align = 64
    written.set_metadata("nontemporal", builder.module.add_metadata([ir.Constant(_NUMBER, 1)]))


@operation(types.none, ARRAY, types.intp, row)
def store_bytes(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, values: ir.Value) -> None:
    """Write a row, whose numbers must be below 256, to a uint8 array from ``index`` on."""
    builder.store(builder.trunc(values, _OCTETS), _pointer(builder, data, index, _OCTETS)).align = 1


@operation(row, number)
def splat(builder: ir.IRBuilder, scalar: ir.Value) -> ir.Value:
    """Return a row with one number in all lanes."""
    return _splat(builder, scalar)


@operation(row)
def ramp(_: ir.IRBuilder) -> ir.Value:
    """Return the row 0, 1, … 31."""
    return _constant(list(range(LANES)))


@operation(row, row, row)
def add(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the sums."""
    return builder.add(a, b)


@operation(row, row, row)
def subtract(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the differences."""
    return builder.sub(a, b)


@operation(row, row, row)
def multiply(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the products."""
    return builder.mul(a, b)


@operation(row, row, row)
def shift_right(builder: ir.IRBuilder, values: ir.Value, by: ir.Value) -> ir.Value:
    """Return each number shifted down, by less than 32 bits."""
    return builder.lshr(values, by)


@operation(row, row, row)
def shift_left(builder: ir.IRBuilder, values: ir.Value, by: ir.Value) -> ir.Value:
    """Return each number shifted up, by less than 32 bits."""
    return builder.shl(values, by)


@operation(row, row, row)
def both(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the bitwise and."""
    return builder.and_(a, b)


@operation(row, row, row)
def either(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the bitwise or."""
    return builder.or_(a, b)


@operation(row, row, row)
def differing(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the bitwise exclusive or."""
    return builder.xor(a, b)


@operation(row, row, row)
def least(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the minimum in each lane."""
    return _least(builder, a, b)


@operation(lanes, row, row)
def unlike(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the lanes in which two rows differ."""
    return builder.zext(builder.bitcast(builder.icmp_unsigned("!=", a, b), _NUMBER), _LONG)


@operation(lanes, row, row)
def less(builder: ir.IRBuilder, a: ir.Value, b: ir.Value) -> ir.Value:
    """Return the lanes in which the first row is less."""
    return builder.zext(builder.bitcast(builder.icmp_unsigned("<", a, b), _NUMBER), _LONG)


@operation(lanes, ARRAY, types.intp, number)
def bytes_unlike(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    """Return which of the 32 numbers of a uint8 array from ``index`` on differ from one number."""
    return _bytes_compared(builder, "!=", data, index, value)


@operation(lanes, ARRAY, types.intp, number)
def bytes_below(builder: ir.IRBuilder, data: ir.Value, index: ir.Value, value: ir.Value) -> ir.Value:
    """Return which of the 32 numbers of a uint8 array from ``index`` on are less than one number."""
    return _bytes_compared(builder, "<", data, index, value)


@operation(row, lanes, row, row)
def where(builder: ir.IRBuilder, chosen: ir.Value, yes: ir.Value, no: ir.Value) -> ir.Value:
    """Return one row in a set of lanes and the other elsewhere."""
    return _chosen(builder, chosen, yes, no)


def _moved_from(sources: list[int]) -> list[int]:
    """Return the shuffle mask that takes lanes of a first row, and of a second one where they are out of range."""
    return [source if 0 <= source < LANES else LANES + source % LANES for source in sources]


@operation(row, row, number)
def from_left(builder: ir.IRBuilder, values: ir.Value, entering: ir.Value) -> ir.Value:
    """Shift a row one lane up; ``entering`` becomes lane 0."""
    mask = _constant(_moved_from([lane - 1 for lane in range(LANES)]))
    return builder.shuffle_vector(values, _splat(builder, entering), mask)


@operation(row, row, number)
def from_right(builder: ir.IRBuilder, values: ir.Value, entering: ir.Value) -> ir.Value:
    """Shift a row one lane down; ``entering`` becomes lane 31."""
    mask = _constant(_moved_from([lane + 1 for lane in range(LANES)]))
    return builder.shuffle_vector(values, _splat(builder, entering), mask)


def _lane_by(values: ir.Value, by: int, beyond: ir.Value, builder: ir.IRBuilder) -> ir.Value:
    """Return a row shifted ``by`` lanes up; vacated lanes are taken from ``beyond``."""
    return builder.shuffle_vector(values, beyond, _constant(_moved_from([lane - by for lane in range(LANES)])))


def _scanned(builder: ir.IRBuilder, values: ir.Value, sign: int, sets: tuple[ir.Value, ...] = ()) -> ir.Value:
    most = _constant([0xFFFFFFFF] * LANES)
    for stage in range(5):
        lesser = _least(builder, values, _lane_by(values, sign << stage, most, builder))
        values = _chosen(builder, sets[stage], lesser, values) if sets else lesser
    return values


@operation(row, row)
def least_up_to(builder: ir.IRBuilder, values: ir.Value) -> ir.Value:
    """Return the prefix minima: in each lane the least of it and all lanes below."""
    return _scanned(builder, values, 1)


@operation(row, row)
def least_from(builder: ir.IRBuilder, values: ir.Value) -> ir.Value:
    """Return the suffix minima: in each lane the least of it and all lanes above."""
    return _scanned(builder, values, -1)


@operation(row, row, lanes, lanes, lanes, lanes, lanes)
def least_up_to_in(builder: ir.IRBuilder, values: ir.Value, *runs: ir.Value) -> ir.Value:
    """Return in each lane the least of it and the lanes below in the same run (segmented scan).

    The five sets are the lanes that have at least 1, 2, 4, 8 and 16 lanes below them in their run.
    """
    return _scanned(builder, values, 1, runs)


@operation(row, row, lanes, lanes, lanes, lanes, lanes)
def least_from_in(builder: ir.IRBuilder, values: ir.Value, *runs: ir.Value) -> ir.Value:
    """Return in each lane the least of it and the lanes above in the same run; the sets count lanes above."""
    return _scanned(builder, values, -1, runs)


@operation(row, row)
def sum_up_to(builder: ir.IRBuilder, values: ir.Value) -> ir.Value:
    """Return the prefix sums: in each lane the sum of it and all lanes below."""
    none = _constant([0] * LANES)
    for stage in range(5):
        values = builder.add(values, _lane_by(values, 1 << stage, none, builder))
    return values


@operation(number, row)
def least_of(builder: ir.IRBuilder, values: ir.Value) -> ir.Value:
    """Return the least number of a row."""
    for half in (16, 8, 4, 2, 1):
        low, high = _constant(list(range(half))), _constant(list(range(half, 2 * half)))
        first, second = (builder.shuffle_vector(values, values, mask) for mask in (low, high))
        values = _least(builder, first, second)
    return builder.zext(builder.extract_element(values, ir.Constant(_NUMBER, 0)), _LONG)


def _of_bits(builder: ir.IRBuilder, name: str, bits: ir.Value, *more: ir.Value) -> ir.Value:
    kind = ir.FunctionType(_NUMBER, [_NUMBER, *(value.type for value in more)])
    function = builder.module.declare_intrinsic(name, [_NUMBER], kind)
    return builder.zext(builder.call(function, [builder.trunc(bits, _NUMBER), *more]), _LONG)


@operation(number, lanes)
def first_lane(builder: ir.IRBuilder, bits: ir.Value) -> ir.Value:
    """Return the number of the first lane of a set, which must not be empty."""
    return _of_bits(builder, "llvm.cttz", bits, ir.Constant(_BIT, 1))


@operation(lanes, lanes)
def mirrored(builder: ir.IRBuilder, bits: ir.Value) -> ir.Value:
    """Return a set of lanes in reverse order: lane 0 becomes lane 31."""
    return _of_bits(builder, "llvm.bitreverse", bits)


@operation(number, lanes)
def size(builder: ir.IRBuilder, bits: ir.Value) -> ir.Value:
    """Return the number of lanes in a set."""
    return _of_bits(builder, "llvm.ctpop", bits)
