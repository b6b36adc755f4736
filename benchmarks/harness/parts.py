"""Options of a bench that has several parts."""

from dataclasses import dataclass


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
