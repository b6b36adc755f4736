"""Theta*: any-angle paths of straight lines."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.theta_star_search import ThetaStarSearch, crossed
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits


class ThetaStar(GridPlanner):
    """Plans paths of straight lines at any angle.

    The cost of a line is the integral of the weights of the cells that it crosses. Like moves from cell to cell, a line
    crosses no blocked cell, and where it passes the corner of four cells, all of them are free. Its ends are centres of
    cells. The plan takes three steps: the cost field of moves is grown; Lazy Theta* searches with the field as its
    heuristic (see `ppaas.planners.grid.kernels.theta_star`); and each corner is removed or moved as long as that lowers
    the cost.

    On a map of one cost the path is never longer than the shortest path of moves. It is not always the shortest path at
    any angle: no corner can be improved by moving it to a neighbouring cell, but a path on the other side of an
    obstacle may be shorter.
    """

    name: ClassVar[str] = "theta_star"
    purpose: ClassVar[str] = "Straight lines at any angle: shorter paths than moves from cell to cell give, few turns."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return a path; its cells are all that the lines between its corners cross."""
        field = CostField(
            costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, threads=threads, check=check
        )
        if not field.grow(ends.start):
            return Found(np.empty((0, 2), np.int32), field.settled)
        check()
        search = ThetaStarSearch(costmap, field.values(), self.allow_unknown, check)
        corners = search.tautened(search.corners(ends.start, ends.goal))
        cells, points = crossed(search.cells_of(corners), check)
        return Found(cells, field.settled + search.expanded, points, search.cost(corners))
