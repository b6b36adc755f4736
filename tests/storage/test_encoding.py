"""Records that were kept by an older release are read by this one."""

import msgspec

from storage.encoding import decode
from storage.records import RobotRecord


class RobotBefore(msgspec.Struct):
    """A robot as it was kept before it had a description and properties."""

    id: str
    user: str
    map: str
    model: str = "turtlebot2"
    initial_pose: tuple[float, float, float] = (1.0, 2.0, 0.5)
    cores: float = 0.25
    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    parameters: dict = {}


def test_a_robot_that_was_kept_before_it_had_properties_is_read() -> None:
    kept = msgspec.msgpack.encode(RobotBefore("tb1", "ann", "house", parameters={"amcl": {"min_particles": 100}}))
    robot = decode(kept, RobotRecord)
    assert (robot.id, robot.cores, robot.parameters) == ("tb1", 0.25, {"amcl": {"min_particles": 100}})
    assert (robot.description, robot.properties) == ("", {})
