"""Records that an older release wrote can be read."""

import msgspec

from storage.encoding import decode
from storage.records import Limits, RobotRecord, User


class RobotBefore(msgspec.Struct):
    """A robot as an older release stored it, without description and properties."""

    id: str
    user: str
    map: str
    model: str = "turtlebot2"
    initial_pose: tuple[float, float, float] = (1.0, 2.0, 0.5)
    cores: float = 0.25
    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    parameters: dict = {}


def test_a_robot_stored_before_properties_existed_is_read() -> None:
    kept = msgspec.msgpack.encode(RobotBefore("tb1", "ann", "house", parameters={"amcl": {"min_particles": 100}}))
    robot = decode(kept, RobotRecord)
    assert (robot.id, robot.cores, robot.parameters) == ("tb1", 0.25, {"amcl": {"min_particles": 100}})
    assert (robot.description, robot.properties) == ("", {})


class UserBefore(msgspec.Struct):
    """A user as an older release stored it, without limits."""

    id: str
    password_hash: str
    role: str = "user"


def test_limits_of_a_release_without_quotas_of_bytes_and_versions_are_read() -> None:
    stored = {"id": "ann", "password_hash": "$argon2id$", "role": "user", "limits": {"robots": 7}}
    assert decode(msgspec.msgpack.encode(stored), User).limits == Limits(robots=7)


def test_a_user_stored_before_limits_existed_has_no_limits() -> None:
    user = decode(msgspec.msgpack.encode(UserBefore("ann", "$argon2id$", "admin")), User)
    assert user == User("ann", "$argon2id$", "admin", Limits())
