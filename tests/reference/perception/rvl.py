"""Slow, obvious twin of RVL: depth images to numbers, numbers to nibbles, nibbles to words, and back."""

import struct
from collections.abc import Iterator
from itertools import groupby


def encode(pixels: list[int]) -> bytes:
    """Return the code of depths, as ``RvlCodec::CompressRVL`` writes it."""
    numbers: list[int] = []
    previous = 0
    runs = [(known, list(run)) for known, run in groupby(pixels, key=bool)]
    if runs and runs[0][0]:
        runs.insert(0, (False, []))
    if runs and not runs[-1][0]:
        runs.append((True, []))
    for known, run in runs:
        numbers.append(len(run))
        for depth in run if known else ():
            delta = depth - previous
            numbers.append(2 * delta if delta >= 0 else -2 * delta - 1)
            previous = depth
    digits = "".join(f"{nibble:x}" for number in numbers for nibble in _nibbles(number))
    digits += "0" * (-len(digits) % 8)
    return b"".join(struct.pack("<I", int(digits[at : at + 8], 16)) for at in range(0, len(digits), 8))


def decode(code: bytes, count: int) -> list[int]:
    """Return depths; fewer than ``count`` if the code ends before."""
    words = struct.unpack(f"<{len(code) // 4}I", code[: len(code) // 4 * 4])
    numbers = _numbers(iter([int(digit, 16) for word in words for digit in f"{word:08x}"]))
    pixels: list[int] = []
    previous, known = 0, False
    while len(pixels) < count:
        run = next(numbers, None)
        if run is None or run > count - len(pixels):
            return pixels
        for _ in range(run):
            step = next(numbers, None) if known else 0
            if step is None:
                return pixels
            previous += (step // 2 if step % 2 == 0 else -(step + 1) // 2) if known else 0
            pixels.append(previous % 65536 if known else 0)
        known = not known
    return pixels


def _nibbles(number: int) -> list[int]:
    octal = [int(digit, 8) for digit in reversed(f"{number:o}")]
    return [digit + 8 for digit in octal[:-1]] + octal[-1:]


def _numbers(nibbles: Iterator[int]) -> Iterator[int]:
    octal: list[str] = []
    for nibble in nibbles:
        if len(octal) == 11:
            return
        octal.append(str(nibble % 8))
        if nibble < 8:
            yield int("".join(reversed(octal)), 8)
            octal = []
