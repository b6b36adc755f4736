"""Theta*: paths of straight lines at any angle."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.theta_star_search import StraightSearch, crossed
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits


class ThetaStar(GridPlanner):
    """Plans paths that run straight from corner to corner, at any angle.

    A line weighs the integral of the weights of the cells it crosses, and keeps the rules of moves: it meets no blocked
    cell, and where it goes through the corner of four cells all of them are free. Both its ends are centres of cells.
    First the field of costs-to-go in moves is grown, then Lazy Theta* is led by it (see
    `ppaas.planners.grid.kernels.theta_star`), and last each corner is left out or moved as long as that lowers the
    cost.

    Where all cells weigh the same the path is never longer than the shortest one in moves. It need not be the shortest
    of all: each corner is where no neighbouring cell would be better, but another way round an obstacle may be.
    """

    name: ClassVar[str] = "theta_star"
    purpose: ClassVar[str] = "Straight lines at any angle: shorter paths than moves from cell to cell give, few turns."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the corners of a path; its cells are all that the lines between them cross."""
        field = CostField(
            costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, threads=threads, check=check
        )
        if not field.grow(ends.start):
            return Found(np.empty((0, 2), np.int32), field.settled)
        check()
        search = StraightSearch(costmap, field.values(), self.allow_unknown, check)
        corners = search.tautened(search.corners(ends.start, ends.goal))
        cells, points = crossed(search.cells_of(corners), check)
        return Found(cells, field.settled + search.expanded, points, search.cost(corners))
