"""Gathered notes: one entry of a report for all parts of a file of which the same is true."""

from ppaas.imports.report import ImportOutcome, ImportReport, ReportEntry

NAMED = 3
"""Number of parts that an entry names; the others are counted."""


class GatheredNotes:
    """Parts of a file by what became of them, in the order in which they came up.

    A graph has thousands of edges; a report with a line for each is not read.
    """

    def __init__(self) -> None:
        self._parts: dict[tuple[ImportOutcome, str], list[str]] = {}

    def taken(self, part: str, text: str = "") -> None:
        """Add a part that was taken as it is."""
        self._add(ImportOutcome.TAKEN, part, text)

    def translated(self, part: str, text: str) -> None:
        """Add a part that became another name or value."""
        self._add(ImportOutcome.TRANSLATED, part, text)

    def without_effect(self, part: str, reason: str) -> None:
        """Add a part that is known, but has no effect."""
        self._add(ImportOutcome.NO_EFFECT, part, reason)

    def refused(self, part: str, reason: str) -> None:
        """Add a part that could not be imported."""
        self._add(ImportOutcome.REFUSED, part, reason)

    def write(self, report: ImportReport) -> None:
        """Add the entries to a report."""
        for (outcome, text), parts in self._parts.items():
            report.entries.append(ReportEntry(_named(parts), outcome, text))
        self._parts.clear()

    def _add(self, outcome: ImportOutcome, part: str, text: str) -> None:
        self._parts.setdefault((outcome, text), []).append(part)


def _named(parts: list[str]) -> str:
    more = f" and {len(parts) - NAMED} more" if len(parts) > NAMED else ""
    return ", ".join(parts[:NAMED]) + more
