"""Parts of the reports of imports, as tests compare them."""

from ppaas.imports.parameters.draft import Translation
from ppaas.imports.report import ImportOutcome, ReportEntry


def entry_of(translation: Translation, part: str) -> ReportEntry:
    """Return the only entry of a part."""
    (found,) = [entry for entry in translation[1].entries if entry.part == part]
    return found


def outcomes(translation: Translation) -> dict[str, str]:
    """Return the outcomes by the names of the parts."""
    return {entry.part: entry.outcome.value for entry in translation[1].entries}


def refused(translation: Translation) -> list[str]:
    """Return the texts of the parts that were refused."""
    return [entry.text for entry in translation[1].of(ImportOutcome.REFUSED)]
