"""Every node class runs in both homes: on a robot, in one thread, and in the cloud, with threads for jobs."""

import asyncio
import importlib
import pkgutil
from collections.abc import Callable

import pytest

import ppaas.nodes
from engine.container.executor import NodeExecutor
from ppaas.clone.assembly import DEPTH_CAMERA, LASER_PROC, build_clone
from ppaas.clone.driving import FOLLOW_PATH
from ppaas.clone.people_coordination import build_coordinator
from ppaas.clone.planning_container import build_planning
from ppaas.clone.traffic import build_traffic
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetMapResponse, GetPlanRequest, GetPlanResponse
from ppaas.nodes.base import Node, Payload
from ppaas.nodes.diagnostics.node import DiagnosticsNode
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.recorder.node import RecorderNode
from ppaas.nodes.stop.node import StopNode
from ppaas.people.names import FOLLOW_PERSON, LEG_DETECTOR, TORSO_DETECTOR
from ppaas.people.settings import PeopleSettings
from ppaas.traffic.taking_part import TRAFFIC
from tests.support.waiting import patience
from tests.support.world.places import free_pose, reachable_pose

Build = Callable[[Graph, MapLayers, Pose2D], None]


def a_clone(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    optional = (DEPTH_CAMERA, LASER_PROC, TORSO_DETECTOR, LEG_DETECTOR, FOLLOW_PERSON)  # most robots have none of them
    parameters: dict[str, dict[str, object]] = {name: {} for name in optional}
    build_clone(graph, layers, model="turtlebot2", initial_pose=pose, parameters=parameters)


def a_clone_of_a_robot_that_drives_itself(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_clone(graph, layers, model="turtlebot2", initial_pose=pose, parameters={FOLLOW_PATH: {}})


def a_clone_of_a_robot_in_traffic(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_clone(graph, layers, model="turtlebot2", initial_pose=pose, parameters={TRAFFIC: {}})


def a_mapping_clone(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_clone(graph, None, model="turtlebot2", initial_pose=pose, parameters={DEPTH_CAMERA: {}})


def a_planning_container(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_planning(graph, layers)


def a_coordinator(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_coordinator(graph, layers, PeopleSettings())


def a_traffic_node(graph: Graph, layers: MapLayers, pose: Pose2D) -> None:
    build_traffic(graph, layers)


BUILDS: dict[str, Build] = {"move_base/make_plan": a_clone, "make_plan": a_planning_container}


@pytest.fixture(scope="module")
def layers() -> MapLayers:
    return build_layers(office(seed=1, width=12.0, height=10.0))


def node_classes() -> set[type[Node]]:
    """Return all node classes, except those that only share code."""
    for module in pkgutil.walk_packages(ppaas.nodes.__path__, "ppaas.nodes."):
        importlib.import_module(module.name)
    found, waiting = set[type[Node]](), [Node]
    while waiting:
        below = waiting.pop().__subclasses__()
        found.update(below)
        waiting += below
    return {cls for cls in found if cls.__module__.startswith("ppaas.nodes.") and hasattr(cls, "name")}


def test_all_builds_together_have_every_node_class(layers: MapLayers) -> None:
    built: set[type[Node]] = set()
    robots = a_clone_of_a_robot_that_drives_itself, a_clone_of_a_robot_in_traffic, a_mapping_clone
    for build in (*BUILDS.values(), *robots, a_coordinator, a_traffic_node):
        graph = Graph()
        build(graph, layers, free_pose(layers.grid, seed=1))
        built |= {type(node) for node in graph.nodes.values()}
    added = {DiagnosticsNode, FootprintNode, RecorderNode, StopNode}
    assert built | added == node_classes(), "containers add these to every build"


@pytest.mark.parametrize("service", BUILDS)
async def test_nodes_answer_alike_in_both_homes(service: str, layers: MapLayers) -> None:
    start = free_pose(layers.grid, seed=1)
    goal = reachable_pose(layers.grid, start, seed=2, at_least=3.0)
    header = Header(frame_id="map")
    request = GetPlanRequest(PoseStamped(header, Pose.of(start)), PoseStamped(header, Pose.of(goal)))
    home = NodeExecutor(lambda: None)
    plans = []
    for graph in (Graph(), home.graph):
        BUILDS[service](graph, layers, start)
        assert isinstance(await answer(graph, "static_map", Empty()), GetMapResponse)
        plan = await answer(graph, service, request)
        assert isinstance(plan, GetPlanResponse)
        plans.append([pose.pose for pose in decode(GetPlanResponse, encode(plan)).plan.poses])
    home.close()
    assert len(plans[0]) > 10
    assert plans[0] == plans[1], "the home of a node does not change its answers"


async def answer(graph: Graph, service: str, request: Message) -> Message:
    """Call a service and wait for its response."""
    future: asyncio.Future[Payload | PPaaSError] = asyncio.get_running_loop().create_future()
    graph.call(service, request, future.set_result)
    async with patience(20):
        result = await future
    assert not isinstance(result, PPaaSError), result
    return result if isinstance(result, Message) else result.to_message()
