"""Groups of people who stand together and talk."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator.people_table import PeopleTable

Array = NDArray[np.float64]

NEAR = 1.6
"""Distance between two who talk: the social distance of Hall (The Hidden Dimension, 1966) begins at 1.2 m [m]."""
STILL = 0.3
"""Speed below which a person stands [m/s]."""
LASTS = 3.0
"""Time for which people must have stood [s]."""

FreeBetween = Callable[[Array, Array], bool]
"""Called with two positions [m]; whether no wall is between them."""


def update_groups(table: PeopleTable, now: float, free_between: FreeBetween) -> None:
    """Update who stands together: each group is numbered by the least id in it, others get 0.

    Parameters
    ----------
    table : PeopleTable
    now : float
        [s]
    free_between : callable
        See `FreeBetween`.
    """
    speeds = np.hypot(table.velocities[:, 0], table.velocities[:, 1])
    present = set(table.present)
    for row, person in enumerate(table.rows):
        person.group = 0
        if row not in present or speeds[row] > STILL:
            person.still_since = float("inf")
        else:
            person.still_since = min(person.still_since, now)
    still = [row for row in sorted(present) if now - table.rows[row].still_since >= LASTS]
    for members in _together(table.positions, still, free_between):
        number = min(table.rows[row].id for row in members)
        for row in members:
            table.rows[row].group = number


def _together(positions: Array, rows: list[int], free_between: FreeBetween) -> list[list[int]]:
    """Return the sets of two or more rows that are connected by steps of less than `NEAR`."""
    at = positions[rows]
    x, y = at[:, 0, np.newaxis] - at[:, 0], at[:, 1, np.newaxis] - at[:, 1]
    leader = list(range(len(rows)))

    def lead(k: int) -> int:
        while leader[k] != k:
            k = leader[k]
        return k

    for i, k in np.argwhere(np.triu(x * x + y * y < NEAR * NEAR, 1)).tolist():
        if lead(i) != lead(k) and free_between(at[i], at[k]):
            leader[lead(k)] = lead(i)
    groups: dict[int, list[int]] = {}
    for k, row in enumerate(rows):
        groups.setdefault(lead(k), []).append(row)
    return [members for members in groups.values() if len(members) > 1]
