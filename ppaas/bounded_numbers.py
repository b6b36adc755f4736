"""Parsers of bounded numbers, for command line arguments."""

import math
from collections.abc import Callable

from ppaas.errors import InvalidParameter


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
