"""Interface of cost fields on a grid."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.ends import Cell


class GridField(ABC):
    """Cost-to-go of each cell of a map, as far as the field has grown."""

    @property
    @abstractmethod
    def settled(self) -> int:
        """Number of cells with their final value."""

    @abstractmethod
    def path_from(self, cell: Cell) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from ``cell``, whose value must be final, to a goal."""

    @abstractmethod
    def values(self) -> NDArray[np.float64]:
        """Return the (height, width) costs-to-go; infinite if blocked or not reached."""

    @abstractmethod
    def values_at(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the (n,) costs-to-go of (n, 2) cells, row and column; infinite if blocked or not reached."""
