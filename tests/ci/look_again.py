"""Say whether what failed deserves a second look: ``python -m tests.ci.look_again REPORT`` reads JUnit's report.

Tests over real processes on a computer of two cores meet moments in which nobody gets anything done. Few such failures
are run once more, alone and named; many are no such moment.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

FEW = 6
"""Tests that may fail, of all, and be run once more: one in three thousand. Each is named, and must pass alone."""


LONGEST = 200
"""Length of a reason that is printed."""


def failed(report: str) -> dict[str, str]:
    """Return ``file::test`` of every test that a JUnit report calls failed or broken, in its order, with the reason."""
    found: dict[str, str] = {}
    for case in ET.fromstring(report).iter("testcase"):
        for part in case:
            if part.tag in ("failure", "error"):
                found.setdefault(name_of(case), part.get("message", "").partition("\n")[0][:LONGEST])
    return found


def name_of(case: ET.Element) -> str:
    """Return ``file::test`` of a test of a report."""
    return f"{case.get('file') or case.get('classname')}::{case.get('name')}"


def main(report: str) -> int:
    """Name what failed; return 0 where it is to be run once more."""
    path = Path(report)
    tests = failed(path.read_text(encoding="utf-8")) if path.exists() else {}
    for test, reason in tests.items():
        print(f"failed the first time: {test}: {reason}")  # noqa: T201
    return 0 if 1 <= len(tests) <= FEW else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
