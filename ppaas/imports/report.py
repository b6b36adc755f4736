"""Report of an import: what became of each part of a foreign file."""

from collections.abc import Iterable, Iterator
from enum import Enum

import msgspec
from msgspec.structs import replace

from ppaas.imports.nearest_name import LIKE, nearest_name

MOST_SUGGESTIONS = 200
"""Number of names of a file for which the nearest known one is searched: each takes up to 3 ms."""


class ImportOutcome(Enum):
    """What became of a part of a file.

    ``TAKEN``: under the same name, with the same meaning. ``TRANSLATED``: under another name, or with another value.
    ``NO_EFFECT``: known, and without effect here; the reason is in the text. ``REFUSED``: unknown or invalid; nothing
    of this part was imported.
    """

    TAKEN = "taken"
    TRANSLATED = "translated"
    NO_EFFECT = "no effect"
    REFUSED = "refused"


class ReportEntry(msgspec.Struct, frozen=True):
    """One part of a file.

    Parameters
    ----------
    part : str
        Where it is in the file, as its users write it: ``controller_server.FollowPath.max_vel_x``, ``edges[3]``.
    outcome : ImportOutcome
    text : str
        What it became, why it has no effect, or why it was refused and what to do.
    line : int
        Line of the file, from 1; 0 if the format has no lines or the line is unknown.
    to : str
        Where its value is in the native file: ``parameters.dwa.max_vel_x``; empty if it has no such place.
    """

    part: str
    outcome: ImportOutcome
    text: str = ""
    line: int = 0
    to: str = ""


class ImportReport:
    """Entries of one import, in the order of the file.

    Parameters
    ----------
    source : str
        Name of the file, for people.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.entries: list[ReportEntry] = []
        self._suggestions = MOST_SUGGESTIONS
        self._at: dict[str, int] = {}
        self._before: int | None = None

    def taken(self, part: str, text: str = "", line: int = 0, *, to: str = "") -> None:
        """Add a part that was taken as it is."""
        self._add(ReportEntry(part, ImportOutcome.TAKEN, text, line, to))

    def translated(self, part: str, text: str, line: int = 0, *, to: str = "") -> None:
        """Add a part that became another name or value."""
        self._add(ReportEntry(part, ImportOutcome.TRANSLATED, text, line, to))

    def _add(self, entry: ReportEntry) -> None:
        if entry.to:
            self._before = self._at.get(entry.to)
            self._at[entry.to] = len(self.entries)
        self.entries.append(entry)

    def replaces_earlier(self, text: str) -> None:
        """Report that the part added last replaces the value that was at its place in the native file.

        Parameters
        ----------
        text : str
            Why the part of the earlier value has no effect. Nothing is changed if the last part has no value there.
        """
        place, before = self.entries[-1].to, self._before
        if place and before is not None and self.entries[before].to == place:
            self.entries[before] = replace(self.entries[before], outcome=ImportOutcome.NO_EFFECT, text=text, to="")

    def without_effect(self, part: str, reason: str, line: int = 0) -> None:
        """Add a part that is known, but has no effect."""
        self.entries.append(ReportEntry(part, ImportOutcome.NO_EFFECT, reason, line))

    def refused(self, part: str, reason: str, line: int = 0) -> None:
        """Add a part that could not be imported."""
        self.entries.append(ReportEntry(part, ImportOutcome.REFUSED, reason, line))

    def nearest_name(self, name: str, known: Iterable[str], likeness: float = LIKE) -> str | None:
        """Return the known name that is most like a name of the file; None for a file with very many such names."""
        self._suggestions -= 1
        return nearest_name(name, known, likeness) if self._suggestions >= 0 else None

    def withdraw(self, place: str, outcome: ImportOutcome, text: str) -> None:
        """Change the outcome of all parts whose values were at a place of the native file, or below it.

        Parameters
        ----------
        place : str
            Dotted place, as in the entries: ``parameters.dwa``.
        outcome : ImportOutcome
            ``REFUSED`` or ``NO_EFFECT``: the value is no part of the native file any more.
        text : str
            The reason.
        """
        for index, entry in enumerate(self.entries):
            if entry.to == place or entry.to.startswith(f"{place}."):
                self.entries[index] = replace(entry, outcome=outcome, text=text, to="")

    def of(self, outcome: ImportOutcome) -> Iterator[ReportEntry]:
        """Return the entries with one outcome."""
        return (entry for entry in self.entries if entry.outcome is outcome)

    def counts(self) -> dict[str, int]:
        """Return the number of entries by the name of their outcome; all four names are present."""
        return {outcome.value: sum(1 for _ in self.of(outcome)) for outcome in ImportOutcome}

    def summary(self) -> str:
        """Return one line: ``nav2_params.yaml: 41 taken, 12 translated, 30 no effect, 0 refused``."""
        return f"{self.source}: " + ", ".join(f"{count} {name}" for name, count in self.counts().items())
