"""Output of the report of an import."""

import json

import pytest

from ppaas.imports.report import ImportReport
from robots.cli.import_report import print_report


def report() -> ImportReport:
    made = ImportReport("slam.yaml")
    made.taken("slam_toolbox.map_frame", line=4)
    made.refused("slam_toolbox.modee", "unknown; meant: mode", line=9)
    return made


def test_a_report_is_a_table_and_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    print_report(report())
    out, err = capsys.readouterr()
    assert out == ""
    assert [line.split() for line in err.splitlines()] == [
        ["part", "outcome", "text"],
        ["4:", "slam_toolbox.map_frame", "taken", "-"],
        ["9:", "slam_toolbox.modee", "refused", "unknown;", "meant:", "mode"],
        ["slam.yaml:", "1", "taken,", "0", "translated,", "0", "no", "effect,", "1", "refused"],
    ]


def test_a_report_is_one_line_of_json(capsys: pytest.CaptureFixture[str]) -> None:
    print_report(report(), as_json=True)
    document = json.loads(capsys.readouterr().err)
    assert document["counts"] == {"taken": 1, "translated": 0, "no effect": 0, "refused": 1}
    assert document["entries"][1] == {
        "part": "slam_toolbox.modee", "outcome": "refused", "text": "unknown; meant: mode", "line": 9, "to": "",
    }  # fmt: skip
