"""Slow, obvious twins of the shortest curves: all words written out, with lengths found by a numerical solver."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import fsolve

QUARTER = math.pi / 2

# Each piece is its direction (L, S, R), its gear (+, -), and its length: an unknown t, u, v, or a quarter turn q.
REEDS_SHEPP_WORDS = [
    "L+t R-u L+v", "L+t R-u L-v", "L+t R+u L-v",
    "L+t S+u L+v", "L+t S+u R+v",
    "L+t R+u L-u R-v", "L+t R-u L-u R+v",
    "L+t R-q S-u L-v", "L+t R-q S-u R-v", "L+t S+u L+q R-v", "L+t S+u R+q L-v",
    "L+t R-q S-u L-q R+v",
]  # fmt: skip
"""The words of Reeds and Shepp (1990), table 1, up to swapping the gears and swapping left and right."""

DUBINS_WORDS = ["L+t S+u L+v", "L+t S+u R+v", "L+t R+u L+v"]
"""The words of Dubins (1957), up to swapping left and right."""

Goal = tuple[float, float, float]
Piece = tuple[float, float]


def end_of(pieces: Sequence[Piece], steps: int = 400) -> Goal:
    """Return the end of pieces of (curvature, signed length) from the origin, by small straight steps."""
    place, heading = 0j, 0.0
    for curvature, length in pieces:
        for _ in range(steps):
            step = length / steps
            middle = heading + curvature * step / 2
            # Chord length of the step's arc, up to the third order.
            place += step * (1 - (curvature * step) ** 2 / 24) * complex(math.cos(middle), math.sin(middle))
            heading += curvature * step
    return place.real, place.imag, heading


def same_heading(a: float, b: float) -> float:
    """Return the absolute difference of two headings [rad]."""
    return abs(math.remainder(a - b, 2 * math.pi))


def shortest(words: Sequence[str], goal: Goal, swap_gears: bool) -> float:
    """Return the least length of all words that lead to a goal, each solved from many initial guesses."""
    best = math.inf
    for word in words:
        for gears, side in itertools.product((1, -1) if swap_gears else (1,), (1, -1)):
            best = min(best, _solved(word, gears, side, goal))
    return best


def _solved(word: str, gears: int, side: int, goal: Goal) -> float:
    found = math.inf
    for guess in itertools.product((0.3, 1.6, 4.0), (0.3, 1.8), (0.3, 1.6, 4.0)):

        def off(unknowns: np.ndarray) -> list[float]:
            x, y, heading = _exact_end(_pieces(word, gears, side, unknowns))
            turn = heading - goal[2]
            return [x - goal[0], y - goal[1], 2 * math.sin(turn / 2)]

        lengths, _, solved, _ = fsolve(off, guess, full_output=True)
        if solved == 1 and max(map(abs, off(lengths))) < 1e-9 and np.all(lengths > -1e-9):
            found = min(found, sum(abs(length) for _, length in _pieces(word, gears, side, lengths)))
    return found


def _pieces(word: str, gears: int, side: int, unknowns: np.ndarray) -> list[Piece]:
    lengths = {"t": unknowns[0], "u": unknowns[1], "v": unknowns[2], "q": QUARTER}
    turns = {"L": side, "S": 0, "R": -side}
    return [(turns[p[0]], gears * (1 if p[1] == "+" else -1) * lengths[p[2]]) for p in word.split()]


def _exact_end(pieces: Sequence[Piece]) -> Goal:
    place, heading = 0j, 0.0
    for curvature, length in pieces:
        after = heading + curvature * length
        if curvature:
            centre = place + 1j / curvature * complex(math.cos(heading), math.sin(heading))
            place = centre - 1j / curvature * complex(math.cos(after), math.sin(after))
        else:
            place += length * complex(math.cos(heading), math.sin(heading))
        heading = after
    return place.real, place.imag, heading
