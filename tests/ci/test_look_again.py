"""What failed is run once more where it is little, and named."""

from pathlib import Path

import pytest

from tests.ci.look_again import FEW, failed, main


def report(failures: int, errors: int = 0) -> str:
    """Return a JUnit report with so many tests of each kind, and one that passed."""
    bad = [
        f'<testcase file="tests/a.py" classname="tests.a" name="f{i}"><failure message="no"/></testcase>'
        for i in range(failures)
    ]
    bad += [
        f'<testcase file="tests/a.py" classname="tests.a" name="e{i}"><error message="no"/></testcase>'
        for i in range(errors)
    ]
    skipped = '<testcase file="tests/b.py" classname="tests.b" name="s"><skipped message="why"/></testcase>'
    good = '<testcase file="tests/b.py" classname="tests.b" name="good"><system-out>failure</system-out></testcase>'
    return f"<testsuites><testsuite>{''.join(bad)}{skipped}{good}</testsuite></testsuites>"


def test_what_failed_or_broke_is_named_once() -> None:
    assert list(failed(report(2, 1))) == ["tests/a.py::f0", "tests/a.py::f1", "tests/a.py::e0"]
    twice = report(1).replace(
        "</testsuite>", '<testcase file="tests/a.py" name="f0"><error message="at its end"/></testcase></testsuite>'
    )
    assert failed(twice) == {"tests/a.py::f0": "no"}


def test_the_first_line_of_a_reason_is_kept() -> None:
    long = report(1).replace('"no"', f'"{"x" * 300}&#10;and more"')
    assert failed(long) == {"tests/a.py::f0": "x" * 200}


@pytest.mark.parametrize(("bad", "status"), [(0, 1), (1, 0), (FEW, 0), (FEW + 1, 1)])
def test_only_little_is_looked_at_again(
    bad: int, status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "report.xml"
    path.write_text(report(bad))
    assert main(str(path)) == status
    assert capsys.readouterr().out.count("failed the first time: tests/a.py::f") == bad


def test_without_a_report_nothing_is_looked_at_again(tmp_path: Path) -> None:
    assert main(str(tmp_path / "none.xml")) == 1
