"""Each suite of the Makefile collects all files that have tests of it."""

import re
from pathlib import PurePath

import pytest

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
