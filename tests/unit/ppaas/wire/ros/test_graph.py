"""The release of ROS 2 by the hashes in its graph."""

import pytest

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import DISTINCTIVE, ROS_2_RELEASES, Entity, Kind, Qos, release_of

WAYPOINTS, FEEDBACK = "nav2_msgs/action/FollowWaypoints_GetResult", "nav2_msgs/action/NavigateToPose_FeedbackMessage"


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


@pytest.mark.parametrize("name", ["lifecycle_msgs/msg/TransitionEvent", FEEDBACK, "nav2_msgs/srv/ClearEntireCostmap"])
def test_lyrical_is_known_by_each_type_that_it_changed_whatever_else_is_there(name: str) -> None:
    lyrical = ros_types("lyrical")
    both = entity(WAYPOINTS, lyrical.type_hash(WAYPOINTS))
    changed = entity(name, lyrical.type_hash(name))
    assert release_of([both, changed]) == release_of([changed, both]) == release_of([changed]) == "lyrical"
    before = entity(name, ros_types("kilted").type_hash(name))
    assert release_of([both, before]) == "kilted"
    assert release_of([before]) is None, "Jazzy and Kilted have it"


def test_nodes_of_two_releases_are_those_of_the_one_that_a_single_type_names() -> None:
    jazzy, lyrical = ros_types("jazzy"), ros_types("lyrical")
    mixed = [entity(FEEDBACK, lyrical.type_hash(FEEDBACK)), entity(WAYPOINTS, jazzy.type_hash(WAYPOINTS))]
    assert release_of(mixed) == "lyrical"


def test_every_distinctive_hash_is_that_of_a_type_in_exactly_its_releases() -> None:
    names = [WAYPOINTS, FEEDBACK, "lifecycle_msgs/msg/TransitionEvent", "nav2_msgs/srv/ClearEntireCostmap"]
    seen: dict[str, tuple[str, ...]] = {}
    for release in ROS_2_RELEASES:
        for name in names:
            one = ros_types(release).type_hash(name)
            seen[one] = (*seen.get(one, ()), release) if release not in seen.get(one, ()) else seen[one]
    assert seen == dict(DISTINCTIVE)


def test_types_without_hashes_are_those_of_humble() -> None:
    assert release_of([entity("std_msgs/msg/Header", "TypeHashNotSupported")]) == "humble"


def test_types_that_are_the_same_everywhere_tell_nothing() -> None:
    assert release_of([entity("std_msgs/msg/Header", ros_types("jazzy").type_hash("std_msgs/Header"))]) is None
    assert release_of([]) is None
