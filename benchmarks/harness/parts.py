"""Options of a bench that has several parts, and their results."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from benchmarks.harness.figures import Figure


@dataclass(frozen=True, slots=True)
class PartSelection:
    """Parts to measure, and the number of samples.

    Parameters
    ----------
    only : tuple of str
        Names of parts; empty for all.
    quick : bool
        Whether to take few samples.
    """

    only: tuple[str, ...] = ()
    quick: bool = False

    def wants(self, part: str) -> bool:
        """Return whether a part is to be measured."""
        return not self.only or part in self.only


class PartResult(NamedTuple):
    """Result of a part.

    Parameters
    ----------
    figures : list of Figure
        Quantities that have bars, and baselines.
    rows : list of dict
        Details for people; all rows have the same keys.
    results : list of dict
        Complete results for programs.
    """

    figures: list[Figure]
    rows: list[dict[str, str]]
    results: list[dict[str, Any]]

    @classmethod
    def failed(cls, part: str, error: Exception) -> "PartResult":
        """Return a figure that misses its bar, with the reason."""
        return cls([Figure(part, "measured", 0, "", limit=1.0, floor=True, note=str(error))], [], [])
