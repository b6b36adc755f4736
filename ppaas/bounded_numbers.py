"""Numbers on command lines, for ``type=`` of arguments."""

import argparse
import math
from collections.abc import Callable


def whole(least: int = 1, most: int | None = None) -> Callable[[str], int]:
    """Return what reads a whole number within bounds; ``ArgumentTypeError`` where the text is none."""
    bounds = f"from {least} up" if most is None else f"from {least} to {most}"

    def read(text: str) -> int:
        number = int(text) if text.isdecimal() else least - 1
        if number < least or (most is not None and number > most):
            raise argparse.ArgumentTypeError(f"give a whole number {bounds}, not {text!r}")
        return number

    return read


def above_zero(most: float) -> Callable[[str], float]:
    """Return what reads a number above 0 and up to a bound; ``ArgumentTypeError`` where the text is none."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not 0.0 < number <= most:
            raise argparse.ArgumentTypeError(f"give a number above 0 and up to {most:g}, not {text!r}")
        return number

    return read
