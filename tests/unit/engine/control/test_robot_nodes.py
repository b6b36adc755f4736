"""Tests of queries and moves of robots' nodes from REST."""

import msgspec
import pytest

from engine.control.robot_nodes import RobotNodes
from engine.protocols.robot_link import LINK_FACTS
from ppaas.diagnosis.observations.facts import LinkFacts, Observations
from ppaas.errors import Conflict, NotFound, Unavailable
from ppaas.messages import encode
from ppaas.messages.health.watching import ObserveResponse
from ppaas.messages.octomap_msgs import GetOctomapFileRequest, GetOctomapFileResponse
from ppaas.messages.ppaas_msgs import NodeHome, NodeHomes
from ppaas.messages.slam_toolbox import GetPoseGraphResponse, UseJointMapRequest, UseJointMapResponse

AMCL = NodeHome("amcl", "robot", "robot", -1.0, ["a client requested this home"])


class FakePlace:
    """Answers calls of the node monitor."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, bytes]] = []

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        self.calls.append((service, payload))
        return encode(NodeHomes([AMCL]) if service == "node_monitor/list_nodes" else AMCL)


class FakeService:
    """Has one place."""

    def __init__(self) -> None:
        self.known = FakePlace()

    async def place_of(self, user: str, robot: str) -> FakePlace | None:
        return self.known if (user, robot) == ("ann", "tb1") else None


async def test_a_page_of_a_joint_map_is_sent_to_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    service = FakeService()

    async def call(called: str, payload: bytes, timeout: float) -> bytes:
        assert (called, payload) == ("grid_slam/use_joint_map", encode(UseJointMapRequest(0, 3, "AAAA", ["tb2"])))
        return encode(UseJointMapResponse(7))

    monkeypatch.setattr(service.known, "call", call)
    page = UseJointMapRequest(0, 3, "AAAA", ["tb2"])
    assert (await RobotNodes(service.place_of).use_joint_map("ann", "tb1", page)).key_frames == 7  # type: ignore[arg-type]


async def test_requests_are_sent_to_the_robots_node_monitor() -> None:
    service = FakeService()
    nodes = RobotNodes(service.place_of)  # type: ignore[arg-type]
    assert await nodes.homes("ann", "tb1") == [AMCL]
    assert await nodes.run("ann", "tb1", "amcl", "robot") == AMCL
    assert service.known.calls == [
        ("node_monitor/list_nodes", b"{}"), ("node_monitor/run_node", b'{"node":"amcl","home":"robot"}')
    ]  # fmt: skip


async def test_robot_without_a_container_raises_unavailable() -> None:
    with pytest.raises(Unavailable, match="robot 'tb2' has no container now"):
        await RobotNodes(FakeService().place_of).homes("ann", "tb2")  # type: ignore[arg-type]


@pytest.mark.parametrize("page", [GetOctomapFileResponse(), GetOctomapFileResponse("AA==", 8)])
async def test_a_robot_without_a_3d_map_has_an_empty_octomap(
    page: GetOctomapFileResponse, monkeypatch: pytest.MonkeyPatch
) -> None:
    service = FakeService()

    async def call(called: str, payload: bytes, timeout: float) -> bytes:
        assert (called, payload) == ("octomap_server/file", encode(GetOctomapFileRequest(7)))
        if not page.data:
            raise NotFound("service", called)
        return encode(page)

    monkeypatch.setattr(service.known, "call", call)
    assert await RobotNodes(service.place_of).octomap("ann", "tb1", GetOctomapFileRequest(7)) == page  # type: ignore[arg-type]


async def test_a_robot_on_a_published_map_makes_none(monkeypatch: pytest.MonkeyPatch) -> None:
    service = FakeService()
    maps = RobotNodes(service.place_of)  # type: ignore[arg-type]
    answers: list[GetPoseGraphResponse] = [GetPoseGraphResponse("AA==", 1, 3)]

    async def call(called: str, payload: bytes, timeout: float) -> bytes:
        assert (called, payload) == ("pose_graph", b'{"offset":0}')
        if not answers:
            raise NotFound("service", called)
        return encode(answers.pop())

    monkeypatch.setattr(service.known, "call", call)
    assert (await maps.map("ann", "tb1", 0)).key_frames == 3
    with pytest.raises(Conflict, match='makes none: set "map": "new:NAME"'):
        await maps.map("ann", "tb1", 0)
    with pytest.raises(Unavailable, match="no container now"):
        await maps.map("ann", "tb2", 0)


class WatchedPlace(FakePlace):
    """Answers what a clone observes."""

    def __init__(self, robots: int) -> None:
        super().__init__()
        self.robots = robots

    async def call(self, service: str, payload: bytes, timeout: float) -> bytes:
        if service == LINK_FACTS:
            return msgspec.json.encode(LinkFacts(robots=self.robots))
        self.calls.append((service, payload))
        return encode(ObserveResponse(msgspec.json.encode(Observations(seconds=2.0, base="base")).decode()))


@pytest.mark.parametrize(("robots", "seconds", "calls"), [(1, 2.0, 1), (0, 0.0, 0)])
async def test_a_connected_robot_is_watched_and_its_connection_is_added(
    robots: int, seconds: float, calls: int
) -> None:
    service, place = FakeService(), WatchedPlace(robots)
    service.known = place
    seen = await RobotNodes(service.place_of).observe("ann", "tb1", 2.0)  # type: ignore[arg-type]
    assert (seen.seconds, seen.link) == (seconds, LinkFacts(robots=robots))
    assert place.calls == [("diagnostics/observe", b'{"seconds":2.0}')][:calls]
