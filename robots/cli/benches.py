"""Benches of ``ppaas bench``: what one is, and what it returns."""

import argparse
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.progress import Progress

GROUP = "ppaas.benchmarks"
"""Entry points of benches: ``ppaas bench NAME`` runs the one of that name."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Result of a bench.

    Parameters
    ----------
    told : dict
        All of it, for programs: printed as JSON with ``--json``.
    rows : list of dict, optional
        A table for people; all rows have the same keys, the headings.
    text : str, optional
        For people, in place of the table.
    status : int
        Exit status of the command.
    """

    told: dict[str, Any]
    rows: list[dict[str, str]] = field(default_factory=list)
    text: str = ""
    status: int = 0


class Bench(Protocol):
    """What an entry point of the group names: a module with these members, or an object."""

    HELP: str

    def configure(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments; the command adds ``--json``."""
        ...

    def measure(self, arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure, and show the progress."""
        ...
