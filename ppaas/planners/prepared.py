"""Planners that preprocess a map once and then answer many queries on it."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Ends
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits
from ppaas.planners.watch import proceed


class Prepared(ABC):
    """A costmap prepared for one kind of search. Only one thread may use it at once.

    Attributes
    ----------
    expanded : int
        Number of cells, or nodes of an index, that the last query settled.
    """

    expanded: int = 0

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Memory used in addition to the costmap [bytes]."""

    @abstractmethod
    def path(
        self, start_row: int, start_column: int, goal_row: int, goal_column: int, check: Callable[[], None] = proceed
    ) -> NDArray[np.int32]:
        """Return the (n, 2) cells, row and column, of a path between two free cells; empty if there is no path."""

    @abstractmethod
    def twin(self) -> "Prepared":
        """Return a copy for another thread, which shares everything that queries only read."""


class PreparedPlanner(GridPlanner):
    """Planner on prepared maps. A read-only map is prepared once; a writable one for every plan."""

    traits: ClassVar[Traits] = Traits(indexed=True)

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown, smooth=smooth)
        self._last: tuple[Costmap, Prepared] | None = None

    @abstractmethod
    def prepare(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> Prepared:
        """Prepare a map.

        Parameters
        ----------
        costmap : Costmap
            Only read.
        threads : int
            Maximum number of threads of the kernels.
        check : callable
            Called at least every 10 ms of work; an exception from it ends the work.
        """

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells between two ends."""
        prepared = self.prepared(costmap, threads=threads, check=check)
        cells = prepared.path(*ends.start, *ends.goal, check)
        return Found(cells, prepared.expanded)

    def twin(self) -> Self:
        """Return a planner with the same parameters, for another thread; it shares the map that was prepared last."""
        twin = super().twin()
        if self._last is not None:
            twin._last = self._last[0], self._last[1].twin()
        return twin

    def prepared(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> Prepared:
        """Return the prepared costmap; the last one is reused if it is of the same read-only array."""
        if self._last is not None and self._last[0].data is costmap.data:
            return self._last[1]
        prepared = self.prepare(costmap, threads=threads, check=check)
        if not costmap.data.flags.writeable:
            self._last = costmap, prepared
        return prepared
