"""Configuration of DDS by ROS's variables for the discovery of nodes."""

from xml.etree import ElementTree

import pytest

from ppaas.errors import InvalidInput
from robots.bridges.dds.cyclone import LOCALHOST_ONLY, PEERS, RANGE, SERVER, cyclone_configuration


def read(environment: dict[str, str]) -> tuple[list[str], bool, bool]:
    """Return the peers of a configuration, whether it allows multicast, and whether it is confined to loopback."""
    domain = ElementTree.fromstring(cyclone_configuration(environment)).find("Domain")
    assert domain is not None
    assert domain.findtext("Compatibility/IgnoreTypeInformation") == "1.15"
    peers = [peer.attrib["address"] for peer in domain.iterfind("Discovery/Peers/Peer")]
    interface = domain.find("General/Interfaces/NetworkInterface")
    return peers, domain.findtext("General/AllowMulticast") != "false", interface is not None


@pytest.mark.parametrize(
    ("environment", "peers", "multicast", "confined"),
    [
        ({}, [], True, False),
        ({RANGE: "", PEERS: ""}, [], True, False),
        ({PEERS: "robot-7; 192.0.2.9;"}, ["robot-7", "192.0.2.9"], True, False),
        ({RANGE: "SUBNET", PEERS: "fd00::7"}, ["fd00::7"], True, False),
        ({RANGE: "LOCALHOST"}, ["localhost"], False, True),
        ({RANGE: "LOCALHOST", PEERS: "127.0.0.2"}, ["localhost", "127.0.0.2"], False, True),
        ({RANGE: "LOCALHOST", PEERS: "192.0.2.9"}, ["localhost", "192.0.2.9"], False, False),
        ({RANGE: "SYSTEM_DEFAULT", PEERS: "192.0.2.9"}, [], True, False),
        ({LOCALHOST_ONLY: "1", RANGE: "SUBNET", PEERS: "192.0.2.9"}, ["localhost"], False, True),
        ({LOCALHOST_ONLY: "0", RANGE: "SUBNET"}, [], True, False),
    ],
)
def test_range_and_peers_are_obeyed_as_by_nodes_of_ros(environment, peers, multicast, confined):
    assert read(environment) == (peers, multicast, confined)


def test_a_peer_cannot_write_configuration():
    assert read({PEERS: '"/><Peer address="x'})[0] == ['"/><Peer address="x']


@pytest.mark.parametrize(
    ("wanted", "text"), [("OFF", "keeps the bridge from finding any robot"), ("EVERYWHERE", "must be one of SUBNET")]
)
def test_a_range_in_which_no_robot_is_found_is_refused(wanted, text):
    with pytest.raises(InvalidInput, match=text):
        cyclone_configuration({RANGE: wanted})


def test_a_discovery_server_is_refused_with_what_to_do():
    with pytest.raises(InvalidInput, match=r"ROS_DISCOVERY_SERVER .* take --transport rclpy .* in ROS_STATIC_PEERS"):
        cyclone_configuration({SERVER: "192.0.2.9:11811"})
    assert read({SERVER: ""}) == ([], True, False)
