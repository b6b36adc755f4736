"""No test is skipped unseen."""

import subprocess
import sys

from tests.ci.check_skips import main, unlisted

REPORT = """<testsuites><testsuite>
<testcase classname="tests.maps.test_io" name="test_a"/>
<testcase classname="tests.maps.test_io" name="test_b[x]"><skipped message="no real data"/></testcase>
<testcase classname="" name="tests.unit.storage.hdfs.test_store"><skipped message="no server: set HDFS"/></testcase>
</testsuite></testsuites>"""


def test_a_skip_that_is_not_listed_is_found():
    assert unlisted(REPORT, "# nothing\n\n") == [
        "tests.maps.test_io::test_b[x]: no real data",
        "tests.unit.storage.hdfs.test_store::tests.unit.storage.hdfs.test_store: no server: set HDFS",
    ]


def test_a_listed_skip_is_allowed_by_its_test_or_its_reason():
    assert unlisted(REPORT, "tests.maps.test_io::test_b[x]: *\n*: no server: set HDFS") == []


def test_a_pattern_must_match_the_whole_of_it():
    assert len(unlisted(REPORT, "tests.maps.test_io\nno server: set HDFS")) == 2


def test_the_command_fails_and_names_the_skip(tmp_path, capsys):
    report, allowed = tmp_path / "junit.xml", tmp_path / "allowed"
    report.write_text(REPORT)
    allowed.write_text("*no real data")
    assert main(str(report), str(allowed)) == 1
    assert "no server: set HDFS" in capsys.readouterr().out
    allowed.write_text("*")
    assert main(str(report), str(allowed)) == 0


SKIPPING = """
import pytest

@pytest.mark.skip(reason="by mark")
def test_mark(): ...

def test_call():
    pytest.skip("by call")

@pytest.mark.xfail(reason="known")
def test_fails():
    raise AssertionError
"""


def test_the_report_of_pytest_itself_is_understood(tmp_path):
    (tmp_path / "test_skips.py").write_text(SKIPPING)
    (tmp_path / "test_module.py").write_text("import pytest\npytest.skip('whole file', allow_module_level=True)")
    command = [sys.executable, "-m", "pytest", "--rootdir=.", "--junit-xml=junit.xml"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=60, check=False).returncode == 0
    report = (tmp_path / "junit.xml").read_text()
    assert len(unlisted(report, "")) == 4
    assert unlisted(report, "*: by mark\n*::test_call: by call\n*: known\ntest_module::*: whole file") == []
