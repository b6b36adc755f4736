"""Lists of numbers as bytes, short where each is close to the one before."""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.plans.encoding.kernels.recipes import MOST, read_recipes, write_recipes


def recipes_of(numbers: Sequence[int], stops: NDArray[np.int64]) -> list[bytes]:
    """Return lists as bytes: each number by how it differs from the one before, seven bits a byte.

    Parameters
    ----------
    numbers : sequence of int
        Of all lists, one list after the other; up to 2⁶².
    stops : (m,) array
        For each list where it ends.
    """
    out, ends = np.empty(MOST * len(numbers), np.uint8), np.empty(len(stops), np.int64)
    write_recipes(np.array(numbers, np.int64), stops, out, ends)
    data, begin, recipes = out.tobytes(), 0, []
    for end in ends.tolist():
        recipes.append(data[begin:end])
        begin = end
    return recipes


def numbers_in(recipes: Sequence[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the numbers of lists, one list after the other, and where those of each end.

    Raises
    ------
    Unavailable
        The bytes of one end within a number.
    """
    data = np.frombuffer(b"".join(recipes), np.uint8)
    numbers, stops = np.empty(len(data), np.int64), np.zeros(len(recipes), np.int64)
    ends = np.array(list(itertools.accumulate(map(len, recipes))), np.int64)
    if not read_recipes(data, ends, numbers, stops):
        raise Unavailable("a stored recipe is damaged: restore it from a backup")
    return numbers[: stops[-1] if len(stops) else 0], stops


def read_recipe(data: bytes) -> list[int]:
    """Return the numbers of one list; ``Unavailable`` if it is damaged."""
    numbers: list[int] = numbers_in([data])[0].tolist()
    return numbers
