"""Step 3: identical persons recognized across robots, and the People Counter.

Each robot names the people that it sees on its own. A torso is given to the person whose predicted position explains
it best, all torsos of a robot together, since two torsos of one robot are two people. Torsos that are nobody known are
compared with each other in the same way.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.tracks.assignment import assign

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

NOBODY = -1
REFERENCE = 0.3**4
"""Determinant of the covariance of a usual prediction [m⁴], relative to which wider ones cost more."""
LONGEST_WALK = 3.0
"""Time after which somebody who walked while hidden can be anywhere, so that any newcomer may be another person [s]."""
KEPT = 12.0
"""Reduction of the cost of the person that a torso was before."""
CERTAIN = 0.5
"""Distance to the person that a torso was before within which it is that person, if no other person is near [m]."""
APART = 0.35
"""Distance between the torsos of one person whom two robots see, apart from 0.7 of both deviations together [m]."""
CLEARLY = 0.4
"""Distance by which any other person must be farther from such a torso [m]."""
SUDDEN = 0.2
"""Standard deviation of what people do that no model of motion foresees, in a cycle [m]."""
STAYS, STANDING = 4.0, 10.0
"""Cost of a person who stayed while hidden: twice the logarithm of the odds of having gone at once, and the mean time
of standing [s]."""
FASTEST = 2.5
"""Speed with which a person who is hidden may move [m/s]."""


@dataclass(frozen=True, slots=True)
class Torsos:
    """T torsos of all robots, in the frame of the map.

    Parameters
    ----------
    robots : (T,) int array
        Numbers of their robots; torsos of one robot are neighbours, and robots are in the order of precedence.
    positions, covariances : (T, 2), (T, 2, 2) array
        At the time of the people's predictions [m, m²].
    deviations : (T,) array
        Maximum position deviations of their robots [m].
    before : (T,) int array
        Number of the person that each was before; `NOBODY` for a new torso.
    """

    robots: Ints
    positions: Array
    covariances: Array
    deviations: Array
    before: Ints

    def part(self, rows: Ints) -> "Torsos":
        """Return some of the torsos."""
        return Torsos(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


@dataclass(frozen=True, slots=True)
class Known:
    """N people, as they were predicted.

    Parameters
    ----------
    positions, covariances : (N, 2), (N, 2, 2) array
        [m, m²].
    deviations : (N,) array
        Least deviation of the robots that saw them last [m].
    hidden : (N,) array
        Time for which nobody has seen them [s].
    """

    positions: Array
    covariances: Array
    deviations: Array
    hidden: Array


def recognize(torsos: Torsos, known: Known, parameters: CoordinatorParameters) -> Ints:
    """Return the number of the person that each torso is; from N on for those that are new people.

    The paper: "identical persons recognized across robots". Torsos and people are compared within a gate that both
    robots' maximum position deviations widen.

    Parameters
    ----------
    torsos : Torsos
    known : Known
    parameters : CoordinatorParameters
    """
    apart = _distances(torsos.positions, known.positions)
    people = _unmistakable(torsos, apart)
    rest = np.flatnonzero(people == NOBODY)
    if len(rest) and apart.size:
        people[rest] = _recognized(torsos.part(rest), known, apart[rest], parameters)
    _split(torsos, people, apart)
    return _with_newcomers(torsos, people, len(known.positions), parameters)


def people_counter(identities: Iterable[int]) -> int:
    """Return the number of different people whom robots see: the true total.

    The paper: the "People Counter". A person whom several robots see counts once.

    Parameters
    ----------
    identities : iterable of int
        Id of the person that each torso of each robot is.
    """
    return len(set(identities))


def _distances(torsos: Array, people: Array) -> Array:
    """Return the (T, N) distances [m]."""
    x = torsos[:, 0, np.newaxis] - people[:, 0]
    y = torsos[:, 1, np.newaxis] - people[:, 1]
    return np.sqrt(x * x + y * y)


def _by_robot(robots: Ints, wanted: NDArray[np.bool_]) -> list[Ints]:
    """Return the rows of each robot, of those robots that have wanted rows; they are then all wanted."""
    rows = np.flatnonzero(wanted)
    return np.split(rows, np.flatnonzero(np.diff(robots[rows])) + 1) if len(rows) else []


def _split(torsos: Torsos, people: Ints, apart: Array) -> None:
    """Take the torsos from people, in place, that are too far from another robot's torso to be the same person.

    The torso nearest to the prediction stays: a robot that loses track of a person does not take them along. Without
    a split, two people between whom the prediction lies would be one for ever.
    """
    if not apart.size:
        return
    order = np.lexsort((apart[np.arange(len(people)), people], people))
    numbers, first = np.unique(people[order], return_index=True)
    anchors = order[first][np.searchsorted(numbers, people)]
    off = torsos.positions - torsos.positions[anchors]
    limit = APART + 0.7 * np.hypot(torsos.deviations, torsos.deviations[anchors])
    people[(people != NOBODY) & (np.hypot(off[:, 0], off[:, 1]) > limit)] = NOBODY


def _unmistakable(torsos: Torsos, apart: Array) -> Ints:
    """Return the person that each torso was before, where it is near and no other person is; else `NOBODY`.

    A robot of which any torso is not so is compared as a whole.
    """
    people = np.full(len(torsos.robots), NOBODY, np.intp)
    if not apart.size:
        return people
    bound = torsos.before >= 0
    own = np.where(bound, apart[np.arange(len(people)), torsos.before], np.inf)
    sure = bound & (own < CERTAIN) & ((apart < own[:, np.newaxis] + CLEARLY).sum(axis=1) == 1)
    pairs = torsos.robots * apart.shape[1] + torsos.before
    _, first, times = np.unique(pairs, return_index=True, return_counts=True)
    sure[first[times > 1]] = False
    settled = np.bincount(torsos.robots, ~sure)[torsos.robots] == 0
    people[settled] = torsos.before[settled]
    return people


def _recognized(torsos: Torsos, known: Known, apart: Array, parameters: CoordinatorParameters) -> Ints:
    """Return the person that each torso is, or `NOBODY`; torsos of each robot are assigned together."""
    people = np.full(len(torsos.robots), NOBODY, np.intp)
    walked = FASTEST * np.minimum(known.hidden, LONGEST_WALK)
    reach = parameters.farthest + torsos.deviations[:, np.newaxis] + known.deviations + walked
    rows, columns = np.nonzero(apart < reach)
    costs = _costs(torsos, known, rows, columns, parameters)
    allowed = costs < parameters.new_person
    rows, columns, costs = rows[allowed], columns[allowed], costs[allowed]
    robots = torsos.robots[rows]
    once = np.bincount(rows, minlength=len(people))[rows] == 1
    _, which, times = np.unique(robots * apart.shape[1] + columns, return_inverse=True, return_counts=True)
    ambiguous = np.bincount(robots, ~(once & (times[which] == 1)))[robots] > 0
    people[rows[~ambiguous]] = columns[~ambiguous]
    for pairs in _by_robot(robots, ambiguous):
        torso_rows, torso_at = np.unique(rows[pairs], return_inverse=True)
        known_rows, known_at = np.unique(columns[pairs], return_inverse=True)
        matrix = np.full((len(torso_rows), len(known_rows)), np.inf)
        matrix[torso_at, known_at] = costs[pairs]
        taken, given = assign(matrix, parameters.new_person)
        people[torso_rows[taken]] = known_rows[given]
    return people


def _costs(torsos: Torsos, known: Known, rows: Ints, columns: Ints, parameters: CoordinatorParameters) -> Array:
    """Return the (k,) costs of taking the torsos ``rows`` for the people ``columns``."""
    same = torsos.before[rows] == columns
    # What a robot saw before has the same error of the robot's position in it.
    either = torsos.deviations[rows] ** 2 + known.deviations[columns] ** 2
    wider = np.where(same, 0.0, either / 6.0) + SUDDEN**2
    covariances = torsos.covariances[rows] + known.covariances[columns]
    xx, xy, yy = covariances[:, 0, 0], covariances[:, 0, 1], covariances[:, 1, 1]
    off = torsos.positions[rows] - known.positions[columns]
    costs = _explained(off, (xx + wider, xy, yy + wider), parameters.gate)
    hidden = known.hidden[columns]
    if hidden.any():
        wider = wider + (0.5 * FASTEST * hidden) ** 2
        costs = np.minimum(costs, _explained(off, (xx + wider, xy, yy + wider), parameters.gate))
        costs = np.minimum(costs, _stayed(off, hidden))
    kept: Array = costs - KEPT * same
    return kept


def _stayed(off: Array, hidden: Array) -> Array:
    """Return the costs of (k, 2) differences [m] for people who stood hidden for (k,) times [s]."""
    square = (off**2).sum(axis=-1) / SUDDEN**2
    return np.where((hidden > 0.0) & (square < STAYS), square + STAYS + hidden / STANDING, np.inf)


def _explained(off: Array, covariance: tuple[Array, Array, Array], gate: float) -> Array:
    """Return the costs of (k, 2) differences [m] by their (k,) covariances xx, xy, yy [m²]."""
    xx, xy, yy = covariance
    determinant = np.maximum(xx * yy - xy * xy, 1e-18)
    x, y = off[..., 0], off[..., 1]
    square = (yy * x * x - 2.0 * xy * x * y + xx * y * y) / determinant
    costs: Array = np.where(square < gate, square + np.maximum(np.log(determinant / REFERENCE), 0.0), np.inf)
    return costs


def _with_newcomers(torsos: Torsos, people: Ints, first: int, parameters: CoordinatorParameters) -> Ints:
    """Number the torsos that are nobody known from ``first`` on; torsos of several robots can be one person."""
    unknown = np.flatnonzero(people == NOBODY)
    if not len(unknown):
        return people
    rest = torsos.part(unknown)
    numbers = np.full(len(unknown), NOBODY, np.intp)
    heads: list[int] = []
    for rows in _by_robot(rest.robots, np.ones(len(unknown), np.bool_)):
        own = rest.part(rows)
        so_far = Known(rest.positions[heads], rest.covariances[heads], rest.deviations[heads], np.zeros(len(heads)))
        apart = _distances(own.positions, so_far.positions)
        unbound = Torsos(
            own.robots, own.positions, own.covariances, own.deviations, np.full(len(rows), NOBODY, np.intp)
        )
        numbers[rows] = _recognized(unbound, so_far, apart, parameters)
        for row in rows[numbers[rows] == NOBODY].tolist():
            numbers[row] = len(heads)
            heads.append(row)
    people = people.copy()
    people[unknown] = first + numbers
    return people
