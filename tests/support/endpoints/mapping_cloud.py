"""Control plane of a cloud in which simulated robots make maps."""

from engine.control.views import MappingRobot as Mapping
from ppaas.errors import Unavailable
from ppaas.messages.slam_toolbox import (
    GetPoseGraphRequest,
    GetPoseGraphResponse,
    UseJointMapRequest,
    UseJointMapResponse,
)
from tests.support.endpoints.fake_cloud import FakeCloud, FakeNodes
from tests.support.world.mapping_robot import MappingRobot


class NodesHere(FakeNodes):
    """Nodes of robots in this process."""

    _cloud: "MappingCloud"

    async def map(self, user: str, robot: str, offset: int) -> GetPoseGraphResponse:
        answer: GetPoseGraphResponse = self._cloud.fleet[user, robot].call("pose_graph", GetPoseGraphRequest(offset))
        return answer

    async def use_joint_map(self, user: str, robot: str, page: UseJointMapRequest) -> UseJointMapResponse:
        if robot in self._cloud.deaf:
            raise Unavailable(f"robot {robot!r} has no container now")
        answer: UseJointMapResponse = self._cloud.fleet[user, robot].call("grid_slam/use_joint_map", page)
        return answer


class MappingCloud(FakeCloud):
    """Cloud whose robots' nodes run in this process.

    Attributes
    ----------
    fleet : dict
        Nodes by the user and name of the robot.
    deaf : set of str
        Names of robots whose clones do not answer when they are to take a map.
    """

    def __init__(self, **robots: MappingRobot) -> None:
        super().__init__()
        self.fleet = {("ann", name): robot for name, robot in robots.items()}
        self.mapping = [Mapping("ann", name, "new:office@ann") for name in robots]
        self.deaf: set[str] = set()
        self.nodes = NodesHere(self)
