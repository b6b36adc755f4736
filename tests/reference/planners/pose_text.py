"""Slow, obvious twin of the kernel that writes numbers between pieces of text."""

from collections.abc import Sequence


def number_text(value: float) -> str:
    """Return a number rounded to nine decimals, without trailing zeros but with at least one decimal."""
    billionths = round(abs(value) * 10**9)
    sign = "-" if value < 0.0 and billionths else ""
    whole, rest = divmod(billionths, 10**9)
    decimals = f"{rest:09d}".rstrip("0") or "0"
    return f"{sign}{whole}.{decimals}"


def rows_text(rows: Sequence[Sequence[float]], pieces: Sequence[str]) -> str:
    """Return all rows, each as piece, number, piece, …, number, piece."""
    *before, last = pieces
    return "".join(
        "".join(piece + number_text(value) for piece, value in zip(before, row, strict=True)) + last for row in rows
    )
