"""Parameters of the recorder, and the choice of topics."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.recording.parameters import checked_globs, recorder_parameters, selects


def test_defaults_record_nothing() -> None:
    assert recorder_parameters({}).ring_seconds == 0.0
    assert recorder_parameters({"ring_minutes": 5}).ring_seconds == 300.0


@pytest.mark.parametrize(
    "given",
    [
        {"ring_minutes": -1},
        {"ring_minutes": 61},
        {"max_mb": 0},
        {"max_mb": 513},
        {"topics": []},
        {"topics": ["a b"]},
        {"topics": ["x"] * 65},
        {"rings": 1},
        [],
    ],
)
def test_invalid_parameters_are_refused(given: object) -> None:
    with pytest.raises(InvalidParameter, match="known: max_mb, ring_minutes, topics"):
        recorder_parameters(given)


def test_star_leaves_heavy_topics_out() -> None:
    assert selects(("*",), "scan")
    assert not selects(("*",), "camera/depth/image_raw")
    assert selects(("*", "camera/depth/*"), "camera/depth/image_raw")
    assert selects(("octomap_full",), "octomap_full")
    assert not selects(("scan",), "odom")


def test_globs_may_have_a_leading_slash() -> None:
    assert checked_globs(("/scan", "tf*")) == ("scan", "tf*")
    with pytest.raises(InvalidParameter, match="topics to record"):
        checked_globs(())
