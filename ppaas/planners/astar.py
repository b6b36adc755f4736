"""A*: the same paths as Dijkstra's algorithm, with fewer cells looked at."""

from collections.abc import Callable
from typing import ClassVar

from ppaas.costmap.costmap import Costmap
from ppaas.planners.aimed_field import AimedField
from ppaas.planners.ends import Ends
from ppaas.planners.field_planner import FieldPlanner
from ppaas.planners.grid_field import GridField


class AStar(FieldPlanner):
    """Grows the field towards the start, by the octile distance that is left.

    Paths cost what those of ``dijkstra`` do, and no more cells are settled for them; each takes longer.
    """

    name: ClassVar[str] = "astar"
    purpose: ClassVar[str] = "Cheapest path in the open, where the straight way is nearly free; no preparation."

    def grow(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> tuple[GridField, bool]:
        """Return a field, and whether it reaches the start, whose value is then final."""
        field = AimedField(
            costmap, ends.goal, ends.start, allow_unknown=self.allow_unknown, threads=threads, check=check
        )
        return field, field.grow()
