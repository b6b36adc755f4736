"""Print how long each test took: ``python -m tests.ci.durations REPORT`` reads JUnit's report.

A line is ``SECONDS file::test``, in the order of the report; the time of a fixture is part of the first test that uses
it. ``.ci/run`` keeps the lines of all suites in ``build/ci/durations.txt`` and prints the dearest.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from tests.ci.look_again import name_of


def durations(report: str) -> list[str]:
    """Return a line for each test of a JUnit report."""
    return [f"{float(case.get('time', 0.0)):8.2f} {name_of(case)}" for case in ET.fromstring(report).iter("testcase")]


def main(report: str) -> int:
    """Print the lines of a report, if it exists."""
    path = Path(report)
    for line in durations(path.read_text(encoding="utf-8")) if path.exists() else ():
        print(line)  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
