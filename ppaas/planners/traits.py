"""Capabilities of a planner, for programs that choose one."""

from dataclasses import dataclass
from enum import StrEnum


class Optimal(StrEnum):
    """Costs on which a planner finds the cheapest of all paths from cell to cell."""

    ALWAYS = "always"
    """On any costs."""
    UNIFORM = "uniform"
    """On maps whose free cells all cost the same."""
    NEVER = "never"
    """No guarantee."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Traits:
    """Capabilities of a planner; its `purpose` states in words when to choose it.

    Parameters
    ----------
    optimal : Optimal
        Costs on which its paths are the cheapest.
    weighted : bool
        Whether it considers the costs of free cells, not only which cells are free.
    any_angle : bool
        Whether paths may run at any angle, not only from cell to cell.
    kinematic : bool
        Whether a robot that cannot turn on the spot can drive the paths.
    indexed : bool
        Whether it prepares a map once for many queries.
    incremental : bool
        Whether it replans after a change of the map with less work than the first plan took.
    dimensions : int
        Number of dimensions of its maps: 2 or 3.
    """

    optimal: Optimal = Optimal.NEVER
    weighted: bool = True
    any_angle: bool = False
    kinematic: bool = False
    indexed: bool = False
    incremental: bool = False
    dimensions: int = 2
