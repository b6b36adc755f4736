"""Requested homes of nodes, and the reports of their placement."""

import pytest

from ppaas.errors import NotFound
from ppaas.messages.ppaas_msgs import NodeHome, NodeHomes
from robots.onboard.local_nodes import PlacementReporter, parse_wanted_homes
from robots.onboard.node_manager import NODES


def test_auto_requests_all_nodes_and_names_request_the_robot() -> None:
    assert parse_wanted_homes("auto") == dict.fromkeys(NODES, "")
    assert parse_wanted_homes("move_base, amcl") == {"move_base": "robot", "amcl": "robot"}


@pytest.mark.parametrize("text", ["", "move_bas", "amcl,", "auto,amcl", "map_server"])
def test_unknown_nodes_are_refused_with_the_known_ones(text: str) -> None:
    with pytest.raises(NotFound, match=r"unknown local node .*; known: .*amcl.*auto.*move_base"):
        parse_wanted_homes(text)


def test_requested_nodes_are_reported_once_per_change() -> None:
    reports: list[str] = []
    homes = PlacementReporter(reports.append)
    homes.changed(NodeHomes([NodeHome("amcl"), NodeHome("move_base")]))
    assert reports == [], "no node was requested"
    going = NodeHome("move_base", "cloud", "robot", -1.0, ["a client requested this home"])
    there = NodeHome("move_base", "robot", "robot", -1.0, ["a client requested this home"])
    failed = ["it could not be run on the robot: it fell", "which is bad"]
    homes.note(going)
    for home in (going, there, there, NodeHome("move_base", "robot", "cloud", 1.0, failed)):
        homes.changed(NodeHomes([NodeHome("amcl"), home]))
    homes.changed(NodeHomes([NodeHome("move_base", "cloud", "cloud", 1.0, failed)]))
    assert reports == [
        "move_base moves to the robot: a client requested this home",
        "move_base runs on the robot: a client requested this home",
        "move_base moves back to the cloud: it could not be run on the robot: it fell; which is bad",
        "move_base runs in the cloud: it could not be run on the robot: it fell; which is bad",
    ]
