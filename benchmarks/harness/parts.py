"""What every bench of several parts is asked."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PartSelection:
    """Which parts to measure, and how thoroughly.

    Parameters
    ----------
    only : tuple of str
        PartSelection; none of them means all.
    quick : bool
        Few samples.
    """

    only: tuple[str, ...] = ()
    quick: bool = False

    def wants(self, part: str) -> bool:
        """Tell whether a part is to be measured."""
        return not self.only or part in self.only
