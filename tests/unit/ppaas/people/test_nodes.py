"""Nodes of robots for people, by the parameters in a robot's file."""

import pytest

from ppaas.people.names import hears_coordinator, tracks_people


@pytest.mark.parametrize("name", ["torso_detector", "leg_detector", "people_tracker"])
def test_a_robot_with_a_detector_or_a_tracker_tracks_people(name: str) -> None:
    assert tracks_people({name: {}}) and hears_coordinator({name: {}})


def test_a_robot_that_only_follows_hears_the_coordinator() -> None:
    assert hears_coordinator({"follow_person": {}}) and not tracks_people({"follow_person": {}})
    assert not hears_coordinator({"amcl": {}})
