"""Rules on the content of scans."""

import pytest

from ppaas.diagnosis.observations.facts import ScanFacts
from ppaas.diagnosis.rules.scans import scans
from tests.support.world.diagnosed_robot import healthy

GOOD = {"frame": "laser", "beams": 360, "increment": 0.0175, "range_min": 0.12, "range_max": 12.0, "readings": 0.9}


def test_good_scan_has_no_finding() -> None:
    assert list(scans(healthy(scans=[ScanFacts(**GOOD)]))) == []


@pytest.mark.parametrize(
    ("changed", "kind", "words"),
    [
        ({"range_max": 0.0}, "scan-limits", "no range is between"),
        ({"increment": 0.0}, "scan-angles", "one direction"),
        ({"increment": 1.0}, "scan-angles", "more than one turn"),
        ({"excess": -40.0}, "scan-angles", "40 less than"),
        ({"beams": 0}, "scan-empty", "no ranges"),
        ({"readings": 0.0, "zeros": 1.0}, "scan-no-readings", "All ranges of the scans of 'laser' are 0"),
        ({"readings": 0.0, "empty": 1.0}, "scan-no-readings", "null, NaN or infinite"),
        ({"readings": 0.02, "short": 0.9}, "scan-no-readings", "98 % ranges"),
        ({"readings": 0.0}, "scan-no-readings", "outside range_min and range_max"),
        ({"beams": 5}, "scan-few-beams", "5 beams"),
        ({"intensities": 360}, "scan-intensities", "360 intensities"),
    ],
)
def test_each_fault_of_a_scan_is_found(changed: dict[str, float], kind: str, words: str) -> None:
    [finding] = scans(healthy(scans=[ScanFacts(**GOOD | changed)]))
    assert finding.kind == kind
    assert words in finding.text
    assert finding.advice


def test_each_laser_is_judged_alone() -> None:
    found = list(scans(healthy(scans=[ScanFacts(**GOOD), ScanFacts(**GOOD | {"frame": "rear", "beams": 0})])))
    assert ["'rear'" in finding.text for finding in found] == [True]
