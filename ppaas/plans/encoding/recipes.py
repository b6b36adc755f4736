"""Recipes: the lists of entry numbers that make up plans, as bytes that are short if the numbers are close together."""

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import Unavailable
from ppaas.plans.encoding.kernels.recipes import MOST, read_recipes, write_recipes


def recipes_of(numbers: Sequence[int], stops: NDArray[np.int64]) -> list[bytes]:
    """Return lists as bytes: the difference of each number to the one before, in seven bits a byte.

    Parameters
    ----------
    numbers : sequence of int
        Numbers of all lists, one list after the other; up to 2⁶².
    stops : (m,) int64 array
        For each list the index after its last number.
    """
    out, ends = np.empty(MOST * len(numbers), np.uint8), np.empty(len(stops), np.int64)
    write_recipes(np.array(numbers, np.int64), stops, out, ends)
    data, begin, recipes = out.tobytes(), 0, []
    for end in ends.tolist():
        recipes.append(data[begin:end])
        begin = end
    return recipes


def numbers_in(recipes: Sequence[bytes]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the numbers of all lists, one list after the other, and for each list the index after its last number.

    Raises
    ------
    Unavailable
        The bytes of a list end inside a number.
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
