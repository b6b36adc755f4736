"""Bound of the energy bench: a linear program over all moves, energies and chargers, and where its time goes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.energy.fleet import HANDLING, PER_METRE, PER_SECOND, ChargingFleet
from ppaas.tasks.reach import SPEED, straight

Array = NDArray[np.float64]


class Bound(NamedTuple):
    """Number of tasks, and the time of robots for each part of the work [s], by ``PARTS``."""

    tasks: float
    times: dict[str, float]


PARTS = ("loaded", "handling", "empty", "to chargers", "charging", "idle")
"""Parts of the time of robots: ways with a load, loading and unloading, ways to tasks, to chargers, charging, rest."""


def bound(fleet: ChargingFleet, pairs: Sequence[tuple[int, int]], seconds: float, left: float) -> Bound:
    """Return the number of tasks of this mix that no plan exceeds which leaves as much charge, even one that knows all.

    The linear program counts moves: loaded ones of tasks, empty ones between places, and ones to and from chargers.
    As many moves end at a place as begin there, but for one of each robot. All together have the time of the robots,
    the energy of the batteries and the chargers, and the time of the chargers, a visit of which fills one battery.
    """
    from scipy.optimize import linprog  # noqa: PLC0415 - takes a third of a second

    chargers = list(fleet.sites.chargers.values())
    places = [*fleet.places, *chargers]
    number, stations, robots = len(places), len(fleet.places), len(fleet.robots)
    ways = np.array([[straight(one, other) for other in places] for one in places])
    mix = np.zeros((number, number))
    np.add.at(mix, tuple(np.array(pairs).T), 1.0 / len(pairs))
    # Unknowns: the number of tasks, empty moves, and the time at each charger.
    empty, none = number * number, np.zeros(len(chargers))
    metres = np.concatenate([[float((mix * ways).sum())], ways.ravel(), none])
    at_charger = np.concatenate([np.zeros(1 + empty), none + 1.0])
    leaves, arrives = np.repeat(np.eye(number), number, axis=1), np.tile(np.eye(number), number)
    balance = (mix.sum(1) - mix.sum(0))[:, np.newaxis]
    flow = np.concatenate([balance, leaves - arrives, np.zeros((number, len(chargers)))], axis=1)
    visits = np.concatenate(
        [np.zeros((len(chargers), 1)), -arrives[stations:], fleet.gain * np.eye(len(chargers))], axis=1
    )
    handling = np.concatenate([[2.0 * HANDLING], np.zeros(empty), none])
    times, energies = metres / SPEED + handling + at_charger, metres * PER_METRE - at_charger * fleet.gain
    start = sum(robot.battery.charge for robot in fleet.robots.values() if robot.battery is not None)
    least = robots * seconds * PER_SECOND
    limits = [np.full(2 * number, float(robots)), none, np.array([robots * seconds, start - least - left])]
    most = np.concatenate([np.full(1 + empty, np.inf), none + seconds])
    found = linprog(
        -np.eye(1, len(most))[0],
        np.vstack([flow, -flow, visits, times, energies]),
        np.concatenate(limits),
        bounds=np.stack([np.zeros(len(most)), most], 1),
        method="highs",
    )
    assert found.success, found.message
    return Bound(float(-found.fun), _times(found.x, metres, arrives[stations:].sum(0), robots * seconds))


def _times(found: Array, metres: Array, to_chargers: Array, whole: float) -> dict[str, float]:
    """Return where the time of the robots goes in a solution [s]."""
    driven = found * metres / SPEED
    moves = driven[1 : 1 + len(to_chargers)]
    there = float(moves @ to_chargers)
    parts = {
        "loaded": float(driven[0]),
        "handling": 2.0 * HANDLING * float(found[0]),
        "empty": float(moves.sum()) - there,
        "to chargers": there,
        "charging": float(found[1 + len(to_chargers) :].sum()),
    }
    return parts | {"idle": whole - sum(parts.values())}
