"""Output of the report of an import, as every command that imports a file prints it."""

import sys
from typing import TYPE_CHECKING

import msgspec

from robots.cli.output import table

if TYPE_CHECKING:
    from ppaas.imports.report import ImportReport

COLUMNS = ("part", "outcome", "text")


def print_report(report: "ImportReport", *, as_json: bool = False) -> None:
    """Print a report to standard error: all its parts in a table, then one line with their numbers.

    Parameters
    ----------
    report : ImportReport
    as_json : bool
        Print one line of JSON instead; standard output stays free for the answer of the cloud.
    """
    if as_json:
        document = {"source": report.source, "counts": report.counts(), "entries": report.entries}
        sys.stderr.write(msgspec.json.encode(document).decode() + "\n")
        return
    rows = [
        {
            "part": f"{entry.line}: {entry.part}" if entry.line else entry.part,
            "outcome": entry.outcome.value,
            "text": entry.text or None,
        }
        for entry in report.entries
    ]
    sys.stderr.writelines(line + "\n" for line in (*table(rows, COLUMNS), report.summary()))
