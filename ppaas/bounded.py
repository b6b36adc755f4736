"""Bounds: a dictionary of few entries, packed data of a limited size, and parsers of numbers for command lines."""

import math
import zlib
from collections import OrderedDict
from collections.abc import Callable
from typing import TypeVar

from ppaas.errors import InvalidParameter

K = TypeVar("K")
V = TypeVar("V")


class BoundedDict(OrderedDict[K, V]):
    """Dictionary in the order of the last assignments; beyond its size, an assignment drops the oldest entry.

    A user that reads an entry, too, keeps it with ``move_to_end``.

    Parameters
    ----------
    size : int
        Largest number of entries.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self._size = size

    def __setitem__(self, key: K, value: V) -> None:
        """Assign a value; the entry becomes the newest."""
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._size:
            self.popitem(last=False)


def inflated(packed: bytes | memoryview, most: int, window: int = zlib.MAX_WBITS) -> bytes:
    """Return data that zlib has packed; no more than its limit is unpacked.

    Parameters
    ----------
    packed : bytes or memoryview
        White space and zeros behind the end are ignored.
    most : int
        Largest size of the data [bytes].
    window : int
        Window and headers, as zlib takes them.

    Raises
    ------
    zlib.error
        It is damaged, its end is missing, or other data is behind its end.
    OverflowError
        The data is larger.
    """
    stream = zlib.decompressobj(window)
    data = stream.decompress(packed, most + 1)
    if len(data) > most:
        raise OverflowError(f"more than {most} bytes")
    if not stream.eof:
        raise zlib.error("its end is missing")
    if stream.unused_data.strip(b"\0 \t\r\n"):
        raise zlib.error("other data is behind its end")
    return data


def whole(least: int = 1, most: int | None = None) -> Callable[[str], int]:
    """Return a parser of integers from ``least`` to ``most``, which raises ``InvalidParameter`` for any other text."""
    bounds = f"of at least {least}" if most is None else f"from {least} to {most}"

    def read(text: str) -> int:
        number = int(text) if text.isdecimal() else least - 1
        if number < least or (most is not None and number > most):
            raise InvalidParameter(f"expected a whole number {bounds}, not {text!r}")
        return number

    return read


def above_zero(most: float) -> Callable[[str], float]:
    """Return a parser of numbers above 0 and up to ``most``, which raises ``InvalidParameter`` for any other text."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not 0.0 < number <= most:
            raise InvalidParameter(f"expected a number above 0 and up to {most:g}, not {text!r}")
        return number

    return read
