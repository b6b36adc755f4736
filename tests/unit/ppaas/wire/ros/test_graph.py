"""The release of ROS 2 by the hashes in its graph."""

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos, release_of

WAYPOINTS = "nav2_msgs/action/FollowWaypoints_GetResult"


def entity(type_name: str, type_hash: str) -> Entity:
    return Entity(Kind.CLIENT, "/topic", type_name, Qos(), "/node", "1", type_hash)


def test_a_type_that_differs_between_releases_tells_which_one_it_is() -> None:
    for release in ("jazzy", "kilted"):
        found = [
            entity("std_msgs/msg/Header", ros_types("jazzy").type_hash("std_msgs/Header")),
            entity("acme_msgs/msg/Thing", "RIHS01_0"),
            entity(WAYPOINTS, ros_types(release).type_hash(WAYPOINTS)),
        ]
        assert release_of(found) == release


def test_types_without_hashes_are_those_of_humble() -> None:
    assert release_of([entity("std_msgs/msg/Header", "TypeHashNotSupported")]) == "humble"


def test_types_that_are_the_same_everywhere_tell_nothing() -> None:
    assert release_of([entity("std_msgs/msg/Header", ros_types("jazzy").type_hash("std_msgs/Header"))]) is None
    assert release_of([]) is None
