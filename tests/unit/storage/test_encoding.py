"""Records that were kept by an older release are read by this one."""

import msgspec

from storage.encoding import decode
from storage.records import Limits, RobotRecord, User


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


class UserBefore(msgspec.Struct):
    """A user as it was kept before there were limits of the user's own."""

    id: str
    password_hash: str
    role: str = "user"


def test_a_user_who_was_kept_before_there_were_limits_has_none_of_the_own() -> None:
    user = decode(msgspec.msgpack.encode(UserBefore("ann", "$argon2id$", "admin")), User)
    assert user == User("ann", "$argon2id$", "admin", Limits())
