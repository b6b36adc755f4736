"""Fail on a test that was skipped and should not have been.

A skip that nobody listed is a test that nobody runs. ``python -m tests.ci.check_skips REPORT ALLOWED`` reads
pytest's JUnit report and a list of patterns, one a line, of ``file::test: reason`` with ``*`` for anything.
"""

import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path


def skipped(report: str) -> list[str]:
    """Return ``file::test: reason`` of every test that a JUnit report calls skipped; what is expected to fail too."""
    return [
        f"{case.get('classname') or case.get('name')}::{case.get('name')}: {reason(skip)}"
        for case in ET.fromstring(report).iter("testcase")
        for skip in case.iter("skipped")
    ]


def reason(skip: ET.Element) -> str:
    """Return why; of a file skipped as a whole it stands at the end of the text."""
    message = skip.get("message", "")
    if message == "collection skipped":
        return (skip.text or "").rpartition("Skipped: ")[2].rstrip("')\"")
    return message


def patterns(allowed: str) -> list[re.Pattern[str]]:
    """Return the patterns of a list; ``#`` begins a comment line."""
    lines = (line.strip() for line in allowed.splitlines())
    return [re.compile(re.escape(line).replace(r"\*", ".*"), re.DOTALL) for line in lines if line and line[0] != "#"]


def unlisted(report: str, allowed: str) -> list[str]:
    """Return the skips that no pattern allows."""
    known = patterns(allowed)
    return [skip for skip in skipped(report) if not any(pattern.fullmatch(skip) for pattern in known)]


def main(report: str, allowed: str) -> int:
    """Print what should not have been skipped; return the exit status."""
    faults = unlisted(Path(report).read_text(encoding="utf-8"), Path(allowed).read_text(encoding="utf-8"))
    for fault in faults:
        print(f"skipped, and not in {allowed}: {fault}")  # noqa: T201
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
