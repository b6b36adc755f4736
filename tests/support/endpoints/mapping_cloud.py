"""Control plane of a cloud in which simulated robots make maps."""

from engine.service.views import MappingRobot as Mapping
from ppaas.errors import Unavailable
from ppaas.messages.slam_toolbox import (
    GetPoseGraphRequest,
    GetPoseGraphResponse,
    UseJointMapRequest,
    UseJointMapResponse,
)
from tests.support.endpoints.fake_cloud import FakeCloud
from tests.support.world.mapping_robot import MappingRobot


class MappingCloud(FakeCloud):
    """Cloud whose robots' nodes run in this process.

    Attributes
    ----------
    robots : dict
        Nodes by the user and name of the robot.
    deaf : set of str
        Names of robots whose clones do not answer when they are to take a map.
    """

    def __init__(self, **robots: MappingRobot) -> None:
        super().__init__()
        self.robots = {("ann", name): robot for name, robot in robots.items()}
        self.mapping = [Mapping("ann", name, "new:office@ann") for name in robots]
        self.deaf: set[str] = set()

    async def robot_map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        answer: GetPoseGraphResponse = self.robots[user, robot].call("pose_graph", GetPoseGraphRequest(offset))
        return answer

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        if robot in self.deaf:
            raise Unavailable(f"robot {robot!r} has no container now")
        answer: UseJointMapResponse = self.robots[user, robot].call("grid_slam/use_joint_map", page)
        return answer
