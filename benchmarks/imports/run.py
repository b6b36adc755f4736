"""One import, measured: its time beside a bare parse, its report, and a drive by what it became."""

from collections.abc import Callable
from typing import Any

import msgspec

from benchmarks.imports.kinds import KINDS, ImportKind
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError

MOST_SECONDS, MOST_TIMES = 2.0, 2.0
"""Bars for 10 MB: time of an import [s], and that time in bare parses."""

LARGE = 10_000_000
"""Size of a file to which the bars apply [bytes]; smaller ones have their share of the seconds."""

SHARE = 0.95
"""Bar: part of the files that are imported, and by which a robot then drives."""


class TriedFile(msgspec.Struct):
    """Import of one file.

    Parameters
    ----------
    file, kind : str
    size : int
        Size of the file [bytes].
    seconds, bare : float
        Time of the import, and of a bare parse by the library of the format [s].
    taken, translated, no_effect, refused : int
        Numbers of parts, by what became of them.
    error : str
        Why the whole file was refused; empty if it was imported.
    drove : str
        ``drove 7.3 m in 24 s``, or why not; empty if nothing was to drive by.
    """

    file: str
    kind: str
    size: int
    seconds: float = 0.0
    bare: float = 0.0
    taken: int = 0
    translated: int = 0
    no_effect: int = 0
    refused: int = 0
    error: str = ""
    drove: str = ""

    @property
    def good(self) -> bool:
        """Whether the import worked, and the drive, if one was tried."""
        return not self.error and not self.drove.startswith("no:")


class ImportsReport(msgspec.Struct):
    """Imports of all files."""

    files: list[TriedFile]

    @property
    def passed(self) -> bool:
        """Whether the imports and drives of at least `SHARE` of the files worked."""
        return sum(each.good for each in self.files) >= SHARE * len(self.files)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each file."""
        return [
            {
                "file": each.file, "kind": each.kind or "-", "kB": f"{each.size / 1e3:.1f}",
                "ms": f"{1e3 * each.seconds:.1f}",
                "of a bare parse": f"{each.seconds / each.bare:.1f}" if each.bare else "-",
                "taken": each.taken, "translated": each.translated, "no effect": each.no_effect,
                "refused": each.refused, "then": each.error or each.drove or "-",
            }
            for each in self.files
        ]  # fmt: skip

    def sentences(self) -> list[str]:
        """Return how many were imported and driven by."""
        good = sum(each.good for each in self.files)
        return [f"{good} of {len(self.files)} files were imported, and robots drove by them where they could"]


def try_file(name: str, content: bytes, *, drives: bool) -> TriedFile:
    """Import a file, twice, of which the faster time counts; parse it barely; and let a robot drive by it."""
    kind = next((each for each in KINDS if each.knows(name, content)), None)
    if kind is None:
        return TriedFile(name, "", len(content), error="no: of no known kind")
    tried = TriedFile(name, kind.name, len(content))
    try:
        tried.seconds, (native, report) = _timed(lambda: kind.run(content, name))
    except PPaaSError as error:
        tried.error = f"no: {error.slug}: {error}"
        return tried
    tried.bare = _bare(kind, content)
    counts = report.counts()
    tried.taken, tried.translated, tried.no_effect, tried.refused = counts.values()
    if tried.refused and not tried.taken + tried.translated:
        tried.error = "no: nothing was taken"
        return tried
    if drives and kind.drive is not None:
        tried.drove = kind.drive(native)
    return tried


def _bare(kind: ImportKind, content: bytes) -> float:
    parse = kind.bare
    return 0.0 if parse is None else _timed(lambda: parse(content))[0]


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    best, result = float("inf"), None
    for _ in range(2):
        began = monotonic()
        result = work()
        best = min(best, monotonic() - began)
    return best, result
