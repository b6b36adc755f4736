"""Interface of the benches of ``ppaas bench``, and their result."""

import argparse
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.progress import Progress

GROUP = "ppaas.benchmarks"
"""Group of the benches' entry points; ``ppaas bench NAME`` runs the one of that name."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Result of a bench.

    Parameters
    ----------
    result : dict
        Complete result for programs; printed as JSON with ``--json``.
    rows : list of dict, optional
        Table for people; all rows have the same keys, which are the headings.
    text : str, optional
        Text for people, in place of the table.
    status : int
        Exit status of the command.
    """

    result: dict[str, Any]
    rows: list[dict[str, str]] = field(default_factory=list)
    text: str = ""
    status: int = 0


class Bench(Protocol):
    """Object of an entry point of the group: a module or an object with these members."""

    HELP: str

    def configure(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of the bench; the command adds ``--json``."""
        ...

    def measure(self, arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Run the bench, show its progress, and return the result."""
        ...
