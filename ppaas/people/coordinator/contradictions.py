"""Contradictions between identities: robots that see one of two people should see the other, too."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.people.coordinator.people_table import PeopleTable
from ppaas.people.coordinator.visibility import View, Walls, hidden_by_people, in_views

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Contradictions:
    """Finds the pairs of people of which some robot of either should see the other, in one cycle.

    Parameters
    ----------
    table : PeopleTable
    robots : sequence of str
        Robot IDs, by the numbers of the views.
    views : sequence of View
    walls : Walls
    radius : float
        Radius of people who hide others [m].
    """

    def __init__(
        self, table: PeopleTable, robots: Sequence[str], views: Sequence[View], walls: Walls, radius: float
    ) -> None:
        self._table, self._views, self._walls, self._radius = table, views, walls, radius
        self._within = in_views(views, table.positions)
        self._views_of: dict[str, list[int]] = {}
        for number, view in enumerate(views):
            self._views_of.setdefault(robots[view.robot], []).append(number)
        self._present = np.array(table.present, np.intp)

    def __call__(self, pairs: Sequence[tuple[int, int]]) -> list[bool]:
        """Return for each pair of rows whether some robot of either should see the other; both do not hide anybody."""
        lines = [self._lines(a, b) + self._lines(b, a) for a, b in pairs]
        counts = [len(each) for each in lines]
        views, targets, seers = (np.array([line for each in lines for line in each], np.intp).reshape(-1, 3)).T
        seen = self._clear(views, targets, seers)
        found = []
        for (a, b), start, count in zip(pairs, np.cumsum([0, *counts]).tolist(), counts, strict=False):
            shown = set(targets[start : start + count][seen[start : start + count]].tolist())
            found.append(shown == {a, b})
        return found

    def _lines(self, seen: int, other: int) -> list[tuple[int, int, int]]:
        """Return view, target and person seen for each view with the other of the robots that see one person."""
        views = [view for robot in self._table.rows[seen].seen_by for view in self._views_of.get(robot, ())]
        return [(view, other, seen) for view in views if self._within[view, other]]

    def _clear(self, views: NDArray[np.intp], targets: NDArray[np.intp], seers: NDArray[np.intp]) -> Mask:
        """Return on which lines from views to targets neither a wall nor a third person is."""
        origins = np.array([self._views[view].pose[:2] for view in views.tolist()]).reshape(-1, 2)
        points, bodies = self._table.positions[targets], self._table.positions[self._present]
        apart = (self._present == targets[:, np.newaxis]) | (self._present == seers[:, np.newaxis])
        clear = self._walls.free_between(origins, points)
        clear[clear] = ~hidden_by_people(origins[clear], points[clear], bodies, self._radius, apart[clear])
        return clear
