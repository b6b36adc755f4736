"""navfn: the default planner of ROS, for comparison and for robots that are tuned to its paths."""

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

    The algorithm is ``NavFn`` of ROS's ``navfn`` and Nav2's ``nav2_navfn_planner``: integer weights, potentials
    interpolated between neighbours, steps of half a cell down the gradient. Four defects are fixed: buffers grow, where
    navfn drops cells beyond 10 000; cells at the edge of the map may be entered; the path cuts no corners; and where
    the gradient vanishes the path continues from cell to cell instead of failing.

    ``cells`` are those that the path crosses, except where it only cuts their corner; poses are half a cell apart. In
    the open the path is short and smooth, but not the cheapest: it is found before all potentials are final.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may cross unknown cells, which then weigh 253.
    use_astar : bool
        Whether to expand cells near the start first. Fewer cells are reached, and the path is up to 10 % longer.
    """

    name: ClassVar[str] = "navfn"
    purpose: ClassVar[str] = "Smooth path as ROS's own planner finds it, on one thread; for comparison."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def __init__(self, *, allow_unknown: bool = True, use_astar: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown)
        self.use_astar = use_astar

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells and the points between two ends.

        Raises
        ------
        InvalidPlanner
            The path is too long for navfn's potentials in single precision.
        """
        function = NavigationFunction(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        if not function.grow(ends.start, astar=self.use_astar):
            return Found(np.empty((0, 2), np.int32), function.reached)
        cells, points = function.walk_from(ends.start)
        return Found(cells, function.reached, points)
