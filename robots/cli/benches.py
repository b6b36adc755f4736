"""Interface of the benches of ``ppaas bench``, and their result."""

import argparse
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, Self

from robots.cli.output import table

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

    @classmethod
    def of(cls, report: "BenchReport") -> Self:
        """Return the result of a bench that ended with a report: its table, then its sentences; 1 unless it passed."""
        import msgspec  # noqa: PLC0415 - ``ppaas bench --help`` loads this module

        rows = report.rows()
        text = "\n".join([*(table(rows, tuple(rows[0])) if rows else ()), *report.sentences()])
        return cls(msgspec.to_builtins(report), text=text, status=0 if report.passed else 1)


class BenchReport(Protocol):
    """Report of a bench: a struct with these members."""

    @property
    def passed(self) -> bool:
        """Whether what was measured is within its bars, and no error was found."""
        ...

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of a table, all with the same keys."""
        ...

    def sentences(self) -> list[str]:
        """Return the summary for people, one line each."""
        ...


class Bench(Protocol):
    """Object of an entry point of the group: a module or an object with these members."""

    HELP: str

    def configure(self, parser: argparse.ArgumentParser) -> None:
        """Add the arguments of the bench; the command adds ``--json``."""
        ...

    def measure(self, arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Run the bench, show its progress, and return the result."""
        ...
