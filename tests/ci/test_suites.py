"""Each suite of the Makefile collects all files that have tests of it."""

import re
from pathlib import PurePath

import pytest

from tests.ci.shares import SHARES, place_in_line, share_of
from tests.support.sources import ROOT

MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
VARIABLES = dict(re.findall(r"^(\w+) := (.*)$", MAKEFILE, re.MULTILINE))
SUITES = {
    marker: VARIABLES.get(places.strip('"$()'), places).split()
    for marker, places in re.findall(r'-m (\w+) -o testpaths=("[^"]*"|\S+)', MAKEFILE)
}


def marked(marker: str) -> list[PurePath]:
    """Return the files with a marker, or, for one that is set in ``conftest.py``, the folder."""
    files = [
        file.relative_to(ROOT)
        for file in (ROOT / "tests").rglob("*.py")
        if f"pytest.mark.{marker}" in file.read_text(encoding="utf-8")
    ]
    return [file.parent if file.name == "conftest.py" else file for file in files]


def test_all_suites_with_a_marker_say_where_their_tests_are() -> None:
    assert set(SUITES) == {"clients", "servers", "docker", "ray", "ros", "versions"}


@pytest.mark.parametrize("suite", SUITES)
def test_every_file_with_tests_of_a_suite_is_collected(suite: str) -> None:
    assert all((ROOT / place).exists() for place in SUITES[suite])
    assert marked(suite)
    assert [file for file in marked(suite) if not any(file.is_relative_to(place) for place in SUITES[suite])] == []


@pytest.mark.parametrize("place", [place for places in SHARES.values() for place in places])
def test_what_is_named_is_there(place):
    assert (ROOT / place).exists()


def test_tests_that_share_a_cloud_stay_together_and_go_first():
    drives = {PurePath("tests/e2e/test_drive.py"), PurePath("tests/e2e/test_reuse.py")}
    assert {share_of(file) for file in drives} == {"drives"}
    other = PurePath("tests/unit/ppaas/maps/formats/test_map_files.py")
    assert share_of(other) == other.as_posix()
    assert all(place_in_line(file) < place_in_line(other) for file in drives)
