from pathlib import Path

import pytest

from tests.ci.durations import main

REPORT = """<testsuites><testsuite>
<testcase classname="tests.e2e.test_drive" file="tests/e2e/test_drive.py" name="test_a" time="12.345"/>
<testcase classname="tests.unit.test_b" name="test_b" time="0.1"/>
</testsuite></testsuites>"""


def test_each_test_has_a_line_that_sorts_by_seconds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "report.xml").write_text(REPORT)
    assert main(str(tmp_path / "report.xml")) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert (first.split(), second.split()) == (
        ["12.35", "tests/e2e/test_drive.py::test_a"],
        ["0.10", "tests.unit.test_b::test_b"],
    )
    assert sorted([second, first], reverse=True) == [first, second], "as text too"


def test_a_suite_without_a_report_has_no_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(str(tmp_path / "none.xml")) == 0
    assert capsys.readouterr().out == ""
