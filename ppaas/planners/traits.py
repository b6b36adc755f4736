"""What a planner is for, in terms that a program can choose by."""

from dataclasses import dataclass
from enum import StrEnum


class Optimal(StrEnum):
    """On which costs a planner's paths are the cheapest there are, among paths from cell to cell."""

    ALWAYS = "always"
    """Whatever the cells cost."""
    UNIFORM = "uniform"
    """Where all free cells cost the same."""
    NEVER = "never"
    """Perhaps, but it does not say so."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Traits:
    """What a planner can do; `purpose` says in words when to choose it.

    Parameters
    ----------
    optimal : Optimal
        On which costs its paths are the cheapest.
    weighted : bool
        Whether it heeds what free cells cost, and not only which are free.
    any_angle : bool
        Whether paths may run in any direction, not only from cell to cell.
    kinematic : bool
        Whether a robot that cannot turn on the spot can drive them.
    indexed : bool
        Whether it prepares a map, once, for many queries.
    incremental : bool
        Whether it replans after a change of the map with less work than at first.
    dimensions : int
        Of the maps that it plans on: 2 or 3.
    """

    optimal: Optimal = Optimal.NEVER
    weighted: bool = True
    any_angle: bool = False
    kinematic: bool = False
    indexed: bool = False
    incremental: bool = False
    dimensions: int = 2
