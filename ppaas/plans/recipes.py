"""Lists of numbers as bytes, short where each is close to the one before."""

from collections.abc import Sequence

from ppaas.errors import Unavailable


def write_recipe(numbers: Sequence[int]) -> bytes:
    """Return numbers as bytes: each by how it differs from the one before, seven bits a byte."""
    data, before = bytearray(), 0
    for number in numbers:
        step = number - before
        before = number
        left = step << 1 if step >= 0 else (-step << 1) - 1
        while left >= 128:
            data.append(left & 127 | 128)
            left >>= 7
        data.append(left)
    return bytes(data)


def read_recipe(data: bytes) -> list[int]:
    """Return the numbers that were written.

    Raises
    ------
    Unavailable
        The bytes end within a number.
    """
    numbers, number, left, shift = [], 0, 0, 0
    for byte in data:
        left |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            number += left >> 1 if not left & 1 else -(left + 1 >> 1)
            numbers.append(number)
            left = shift = 0
    if shift:
        raise Unavailable("a stored recipe is damaged: restore it from a backup")
    return numbers
