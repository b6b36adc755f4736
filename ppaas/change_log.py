"""Change logs: what a node appends to its log beside its checkpoint, and removes from it."""

from typing import NamedTuple


class LogEntry(NamedTuple):
    """Entry of a log.

    Parameters
    ----------
    number : int
        Place in the order of the entries; ascending, with gaps.
    data : bytes
    """

    number: int
    data: bytes


class LogChange(NamedTuple):
    """Change of a log, to be made as a whole.

    Parameters
    ----------
    entries : list of LogEntry
        Entries to append.
    obsolete : list of int
        Numbers of entries to remove.
    """

    entries: list[LogEntry]
    obsolete: list[int]

    def then(self, later: "LogChange") -> "LogChange":
        """Return this change and a later one in one; entries that the later one removes are left out."""
        gone = set(later.obsolete)
        entries = [entry for entry in self.entries if entry.number not in gone]
        return LogChange([*entries, *later.entries], [*self.obsolete, *later.obsolete])
