"""Access of the MCP server to the cloud: its REST service by a token, narrowed to some robots."""

import itertools
import math
from collections.abc import Sequence
from typing import Any

from ppaas.errors import NotPermitted, listed
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest, GetPlanResponse
from robots.client.cloud_url import path_of
from robots.client.connection import ConnectionOptions
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient

CONNECT = 10.0
"""Time limit of a connection to a robot's clone [s]."""

PLANNING = 30.0
"""Time limit of a path [s]."""


class NarrowedCloud:
    """What the tools use: requests, each with the rights of the token.

    The server holds no right and checks none, apart from the names of ``robots``: the cloud decides.

    Parameters
    ----------
    url, token : str
        URL of the cloud, and token.
    robots : frozenset of str, optional
        The only robots that are served; all that the token permits by default.
    """

    def __init__(self, url: str, token: str, robots: frozenset[str] | None = None) -> None:
        self._url = url
        self._token = token
        self._robots = robots
        self.rest = RestClient(url, token)

    def serves(self, robot: str) -> bool:
        """Return whether a robot is one of those that are served."""
        return self._robots is None or robot in self._robots

    def path(self, robot: str, *parts: str) -> str:
        """Return a path below a robot in the REST service.

        Raises
        ------
        NotPermitted
            The robot is not one of those that are served.
        """
        if not self.serves(robot):
            raise NotPermitted(f"this server serves {listed(sorted(self._robots or ()))} alone, not {robot}")
        return path_of("robots", robot, *parts)

    async def robots(self, most: int) -> list[dict[str, Any]]:
        """Return the robots of the user, then those that others share with the user, each with its ``address``.

        There are at most ``most`` + 1, so that a caller learns whether there are more.
        """
        found: list[dict[str, Any]] = []
        for shared in (False, True):
            query = {"shared": "true"} if shared else {}
            # Fewer cannot be asked for while some are not served.
            limit = most + 1 - len(found) if self._robots is None else None
            rows = await self.rest.items(path_of("robots"), limit, **query) if limit != 0 else []
            found += [row | {"address": f"{row['user']}:{row['id']}" if shared else row["id"]} for row in rows]
        return [row for row in found if self.serves(row["address"])][: most + 1]

    async def planned(self, robot: str, start: Pose2D | None, goal: Pose2D, tolerance: float) -> list[Pose2D]:
        """Return the path that a robot's clone plans, from the robot by default; empty if there is none.

        Raises
        ------
        PPaaSError
            The reason of the cloud or of the clone.
        """
        self.path(robot)
        # As in move_base, a start without a frame is the robot's pose.
        begin = PoseStamped(Header(), Pose.of(Pose2D(0.0, 0.0))) if start is None else _stamped(start)
        request = GetPlanRequest(begin, _stamped(goal), tolerance)
        link = ConnectionOptions(open_timeout=CONNECT)
        async with RobotClient(
            self._url, robot=robot, token=self._token, role="operator", hold=False, link=link, connect_timeout=CONNECT
        ) as client:
            answer = await client.call("move_base/make_plan", GetPlan, request, PLANNING)
        assert isinstance(answer, GetPlanResponse)
        return [stamped.pose.planar() for stamped in answer.plan.poses if isinstance(stamped, PoseStamped)]


def _stamped(pose: Pose2D) -> PoseStamped:
    return PoseStamped(Header(frame_id="map"), Pose.of(pose))


def length(path: Sequence[Pose2D]) -> float:
    """Return the length of a path [m]."""
    return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in itertools.pairwise(path))
