"""Tables of numbers as text, with blanks, commas or semicolons between them."""

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap

SAMPLE = 1 << 16
"""Size of the begin of a text that decides how it is read [bytes]."""

_WORD = re.compile(rb"[^\s,;]+")
_SEPARATORS = bytes.maketrans(b",;\t\r", b"    ")
_COMMENT = re.compile(rb"^[ \t]*(?:#|//).*$", re.MULTILINE)
_TITLES = re.compile(rb"\A(?:\s*[\"']?(?!(?:nan|inf)\b)[A-Za-z_].*\n)+", re.IGNORECASE)
"""Rows of titles of columns before the first row of numbers, which may begin with nan."""


def number_table(text: bytes, kind: str, columns: int | None = None) -> NDArray[np.float64]:
    """Return a table of numbers.

    Parameters
    ----------
    text : bytes
    kind : str
        Name of the format, for errors.
    columns : int, optional
        Number of columns; that of the first row if None.

    Raises
    ------
    InvalidMap
        A row has another number of columns, or what is no number.
    """
    text = _without_titles(text)
    if columns is None:
        columns = _columns(text, kind)
    if b"," in text[:SAMPLE] or b";" in text[:SAMPLE]:
        text = text.translate(_SEPARATORS)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)
        try:
            numbers = np.fromstring(text, np.float64, sep=" ")
        except (DeprecationWarning, ValueError) as error:
            raise InvalidMap(f"the {kind} has rows with other text than numbers") from error
    if not columns or len(numbers) % columns:
        raise InvalidMap(f"the rows of the {kind} have different numbers of columns; the first has {columns}")
    return np.asarray(numbers.reshape(-1, columns))


def _without_titles(text: bytes) -> bytes:
    """Return the text without comments and titles of columns."""
    if b"#" in text or b"//" in text:
        text = _COMMENT.sub(b"", text)
    return _TITLES.sub(b"", text[:SAMPLE]) + text[SAMPLE:]


def _columns(text: bytes, kind: str) -> int:
    """Return the number of columns of the first row with more than one; one alone is a count of rows."""
    for row in text[:SAMPLE].splitlines():
        count = len(_WORD.findall(row))
        if count > 1:
            return count
    raise InvalidMap(f"the {kind} has no row of numbers")
