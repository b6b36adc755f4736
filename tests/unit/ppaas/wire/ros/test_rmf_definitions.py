"""Hashes of ``rmf_fleet_msgs`` are the ones in the code that ROS generates for the package."""

import pytest

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import ROS_2_RELEASES
from ppaas.wire.ros.rmf_definitions import RMF
from ppaas.wire.ros.rmf_workcells import WORKCELLS
from ppaas.wire.ros.types import NO_HASH

HASHES = {
    "Location": "6136f1fc14b896b572c34746c55dbbfd8862e3c561ad5c957ee8b0c116a0e8df",
    "RobotMode": "9cd4cf773031229f5373fd1b942acf16d140664b79e2463b5e476c1ef6933b2d",
    "FleetState": "9ea5bb9f2c076a587b20c04974581c8d8e2ec7d02300244f9e39e37d7d9192f4",
    "DestinationRequest": "568d7913e870ac8a048d7960dc7c05ce82fd6730c774bbf224ac128ed82c3193",
}


@pytest.mark.parametrize("name", HASHES)
@pytest.mark.parametrize("release", ROS_2_RELEASES)
def test_a_type_has_the_hash_of_ros(name: str, release: str) -> None:
    found = ros_types(release).type_hash(f"rmf_fleet_msgs/msg/{name}")
    assert found == (NO_HASH if release == "humble" else f"RIHS01_{HASHES[name]}")


@pytest.mark.parametrize("name", RMF | WORKCELLS)
def test_an_empty_message_is_coded_and_decoded(name: str) -> None:
    types = ros_types("jazzy")
    assert types.encode(name, types.decode(name, types.encode(name, {}))) == types.encode(name, {})
