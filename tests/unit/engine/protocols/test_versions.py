"""Tests of the agreement on a version of the protocol."""

import pytest

from engine.protocols.versions import OWN, UNSTATED, Protocols, agree
from ppaas.errors import Conflict


@pytest.mark.parametrize(
    ("stated", "own", "agreed"),
    [
        (Protocols(3, 4), Protocols(3, 4), 4),
        (Protocols(3, 4), Protocols(4, 5), 4),
        (Protocols(4, 5), Protocols(3, 4), 4),
        (Protocols(1, 9), Protocols(4, 5), 5),
        (Protocols(5, 5), Protocols(4, 5), 5),
    ],
)
def test_the_highest_version_in_common_is_used(stated: Protocols, own: Protocols, agreed: int) -> None:
    assert agree("machine 'm1'", "9.9.9", stated, own) == agreed


@pytest.mark.parametrize(
    ("stated", "own", "first"),
    [
        (Protocols(3, 4), Protocols(1, 2), "upgrade this process first, to a release that speaks protocol 3"),
        (Protocols(1, 2), Protocols(3, 4), "upgrade machine 'm1' first, to a release that speaks protocol 3"),
    ],
    ids=["newer", "older"],
)
def test_a_peer_beyond_the_range_is_refused_with_what_to_upgrade_first(
    stated: Protocols, own: Protocols, first: str
) -> None:
    with pytest.raises(Conflict) as refused:
        agree("machine 'm1'", "9.9.9", stated, own)
    text = str(refused.value)
    assert "machine 'm1' runs release 9.9.9" in text and f"with {stated}" in text
    assert f"with {own}: {first}" in text


@pytest.mark.parametrize("stated", [Protocols(2, 1), Protocols(-5, -1), Protocols(0, 0)])
def test_an_impossible_range_is_refused(stated: Protocols) -> None:
    with pytest.raises(Conflict):
        agree("endpoint 'hall-1'", "0.2.0", stated)


def test_builds_of_0_2_0_that_state_no_range_are_accepted() -> None:
    assert agree("machine 'm1'", "0.2.0", None) == UNSTATED.newest


@pytest.mark.parametrize("release", ["", "0.1.0", "x" * 1000])
def test_other_releases_without_a_range_are_refused(release: str) -> None:
    with pytest.raises(Conflict, match="unknown protocols") as refused:
        agree("machine 'm1'", release, None)
    assert len(str(refused.value)) < 300


def test_the_release_before_is_spoken() -> None:
    assert OWN.oldest <= OWN.newest - 1 or OWN.newest == 1
