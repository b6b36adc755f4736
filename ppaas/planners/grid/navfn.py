"""navfn: the planner that ROS has by default, as a yardstick and for paths that robots are used to."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.grid.navigation_function import NavigationFunction
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits


class NavFn(GridPlanner):
    """Grows a navigation function until it reaches the start, and follows its gradient to the goal, on one thread.

    The rules are those of ``NavFn`` in ROS's ``navfn`` and Nav2's ``nav2_navfn_planner``: weights in whole numbers,
    potentials interpolated between neighbours, steps of half a cell down the gradient. Four things are mended: its
    buffers grow, where navfn's drop what is beyond 10 000 cells; the cells at the edge of the map may be entered; the
    path cuts no corner; and where the gradient leads nowhere, it goes on from cell to cell instead of giving up.

    The cells are those that the path runs through, but for corners of them, and its poses are half a cell apart. The
    path is short and smooth in the open, and not the cheapest: it is found before all potentials are final.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may lead through unknown cells, which then weigh 253.
    use_astar : bool
        Whether cells go first that are near the start; fewer are reached then, and the path is up to a tenth longer.
    """

    name: ClassVar[str] = "navfn"
    purpose: ClassVar[str] = "Smooth path as ROS's own planner finds it, on one thread; for comparison."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def __init__(self, *, allow_unknown: bool = True, use_astar: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown)
        self.use_astar = use_astar

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the cells and the points between two ends.

        Raises
        ------
        InvalidPlanner
            The way is too long for navfn's potentials.
        """
        function = NavigationFunction(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        if not function.grow(ends.start, astar=self.use_astar):
            return Found(np.empty((0, 2), np.int32), function.reached)
        cells, points = function.walk_from(ends.start)
        return Found(cells, function.reached, points)
