from pathlib import PurePath

import pytest

from tests.ci.shares import SHARES, place_in_line, share_of
from tests.support.sources import ROOT


@pytest.mark.parametrize("place", [place for places in SHARES.values() for place in places])
def test_what_is_named_is_there(place):
    assert (ROOT / place).exists()


def test_tests_that_share_a_cloud_stay_together_and_go_first():
    drives = {PurePath("tests/e2e/test_drive.py"), PurePath("tests/e2e/test_reuse.py")}
    assert {share_of(file) for file in drives} == {"drives"}
    other = PurePath("tests/unit/ppaas/maps/formats/test_map_files.py")
    assert share_of(other) == other.as_posix()
    assert all(place_in_line(file) < place_in_line(other) for file in drives)
