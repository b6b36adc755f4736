"""Planners that prepare a map once and then answer many queries on it."""

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
    """A costmap, prepared for one kind of search; used by one thread at a time.

    Attributes
    ----------
    expanded : int
        Cells, or nodes of an index, that the last query settled.
    """

    expanded: int = 0

    @property
    @abstractmethod
    def nbytes(self) -> int:
        """Bytes that it takes beyond the costmap itself."""

    @abstractmethod
    def path(
        self, start_row: int, start_column: int, goal_row: int, goal_column: int, check: Callable[[], None] = proceed
    ) -> NDArray[np.int32]:
        """Return the (n, 2) cells, row and column, of a path between two free cells on the map; none without a way."""

    @abstractmethod
    def twin(self) -> "Prepared":
        """Return one for another thread, which shares all but what a query writes to."""


class PreparedPlanner(GridPlanner):
    """Plans on a map that it has prepared; a map that nobody can write to is prepared once."""

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
            Most threads that kernels may use.
        check : callable
            Called at least every 10 ms of work; what it raises ends the work.
        """

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Find the cells between two ends."""
        prepared = self.prepared(costmap, threads=threads, check=check)
        cells = prepared.path(*ends.start, *ends.goal, check)
        return Found(cells, prepared.expanded)

    def twin(self) -> Self:
        """Return one with the same parameters, for another thread; it shares what was prepared last."""
        twin = super().twin()
        if self._last is not None:
            twin._last = self._last[0], self._last[1].twin()
        return twin

    def prepared(self, costmap: Costmap, *, threads: int = 1, check: Callable[[], None] = proceed) -> Prepared:
        """Return what was prepared of the costmap last time, or prepare it now; one that may change is always anew."""
        if self._last is not None and self._last[0].data is costmap.data:
            return self._last[1]
        prepared = self.prepare(costmap, threads=threads, check=check)
        if not costmap.data.flags.writeable:
            self._last = costmap, prepared
        return prepared
