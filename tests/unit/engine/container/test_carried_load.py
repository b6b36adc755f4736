"""Clones whose robots carry loads: their outline, their map, and the goals that they have."""

import asyncio
from pathlib import Path

import pytest

from engine.container.current_map import CurrentMap
from engine.container.fleet_bridge import FleetBridge
from engine.container.graph_building import Attendants, build_graph
from engine.specs.containers import ContainerSpec, Launch, MapVersion, RobotConfig
from engine.specs.layer_files import write_layers
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import Unavailable
from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Point32, Polygon, Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseGoal
from ppaas.messages.ppaas_msgs import NodeHome, RunNodeRequest, TellRobotRequest
from ppaas.nodes.graph import Graph
from ppaas.plans.reuse.setup import discard_note
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import EmptyLibrary
from ppaas.robot_model.known_models import robot_model
from ppaas.thread_budget import one_thread
from tests.support.world.planar_world import walled_map

OWN = robot_model("turtlebot2").robot_radius
LOAD = ((0.5, 0.35), (-0.5, 0.35), (-0.5, -0.35), (0.5, -0.35))
BESIDE_WALL = (100, 8)
"""Cell at 0.4 m from the wall."""


class Clone:
    """Graph of a container, with a clone in a room."""

    def __init__(self, folder: Path, checkpoint: dict[str, bytes] | None = None, **parameters: object) -> None:
        if not folder.exists():
            folder.mkdir()
            write_layers(folder, build_layers(walled_map(10, 10, []), robot_radius=OWN), created=0.0)
        robot = RobotConfig("tb1", "turtlebot2", (5.0, 5.0, 0.0), "dijkstra", "dwa", parameters)
        spec = ContainerSpec("c1", "ann", MapVersion("room", "v1"), 1.0, robot, checkpoint or {})
        launch = Launch(spec, str(folder), "", "", secret="", cpus=(0,), threads=1)
        self.current, self.graph = CurrentMap(launch, EmptyLibrary(), Times(), discard_note), Graph()
        made = build_graph(self.graph, launch, one_thread, self.current)
        assert isinstance(made, Attendants)
        self.attendants, self.fitted = made, 0
        made.fitting.fitted = self._count

    def _count(self) -> None:
        self.fitted += 1

    async def carry(self, load: Footprint) -> None:
        """Publish what the robot carries."""
        self.graph.inject("local_costmap/footprint", Polygon([Point32(x, y) for x, y in load]))
        await asyncio.sleep(0)

    @property
    def parameters(self) -> dict[str, object]:
        """Parameters of the robot now."""
        assert self.current.spec.robot is not None
        return self.current.spec.robot.parameters

    @property
    def is_clear(self) -> bool:
        """Whether the middle of the robot may be beside the wall, by its map."""
        assert self.current.layers is not None
        return int(self.current.layers.costmap.data[BESIDE_WALL]) < 253


async def test_all_that_depends_on_the_outline_changes_with_a_load(tmp_path: Path) -> None:
    clone = Clone(tmp_path / "layers", global_costmap={"robot_radius": OWN}, dwa={"robot_radius": 0.1})
    assert clone.is_clear
    before = dict(clone.graph.nodes)
    await clone.carry(LOAD)
    changed = {name for name, node in clone.graph.nodes.items() if before[name] is not node}
    assert changed == {"move_base", "docking_server", "parameter_server"} and clone.fitted == 1
    assert sorted(clone.parameters["global_costmap"]["footprint"]) == sorted(map(list, LOAD))  # type: ignore[index]
    assert "robot_radius" not in clone.parameters["global_costmap"]  # type: ignore[operator]
    assert clone.parameters["dwa"] == {}
    assert not clone.is_clear
    await clone.carry(())
    assert clone.is_clear and clone.parameters["dwa"] == {"robot_radius": 0.1} and clone.fitted == 2


async def test_a_goal_goes_on_with_the_load(tmp_path: Path) -> None:
    clone = Clone(tmp_path / "layers")
    target = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(2.0, 2.0)))
    clone.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(target), GoalID(id="g")))
    await clone.carry(LOAD)
    assert clone.graph.nodes["move_base"].busy
    state = clone.graph.nodes["move_base"].checkpoint()
    assert state is not None and b'"g"' in state


async def test_the_next_container_is_built_for_the_load(tmp_path: Path) -> None:
    clone = Clone(tmp_path / "layers")
    await clone.carry(LOAD)
    kept = {each.node: each.state for each in clone.graph.checkpoints()}
    again = Clone(tmp_path / "layers", kept)
    assert again.current.load == LOAD and not again.is_clear
    again.graph.restore(clone.graph.checkpoints())
    await asyncio.sleep(0)
    assert again.fitted == 0, "it was built so"
    await again.carry(())
    assert again.is_clear and again.parameters == {}


async def test_others_know_how_large_the_robot_is(tmp_path: Path) -> None:
    clone = Clone(tmp_path / "layers")
    spec = clone.current.spec
    launch = Launch(spec, "", "", "", secret="", cpus=(), threads=1)
    bridge = FleetBridge(launch, Graph(), None, lambda: True)  # type: ignore[arg-type]
    assert bridge._radius == OWN
    await clone.carry(LOAD)
    bridge.use_spec(clone.current.spec)
    assert bridge._radius == pytest.approx(0.61, abs=0.002)


async def test_nodes_stay_in_the_cloud_while_the_robot_carries_a_load(tmp_path: Path) -> None:
    clone = Clone(tmp_path / "layers")
    answers: list[object] = []
    computer = TellRobotRequest(4.0, 1.0, 1.0, 0.01, 1e7, ["move_base", "amcl"])
    clone.graph.call("node_monitor/tell_robot", computer, answers.append)
    clone.graph.call("node_monitor/run_node", RunNodeRequest("move_base", "robot"), answers.append)
    await clone.carry(LOAD)
    homes: list[NodeHome] = []
    clone.graph.tap("node_monitor/homes", lambda _, message: homes.extend(message.nodes))  # type: ignore[union-attr]
    [home] = [each for each in homes if each.node == "move_base"]
    assert home.wanted == "cloud" and home.reasons == ["the robot carries a load, which its scans must not show"]
    clone.graph.call("node_monitor/run_node", RunNodeRequest("amcl", "robot"), answers.append)
    assert isinstance(answers[-1], (NodeHome, Unavailable)) and getattr(answers[-1], "wanted", "cloud") == "cloud"
    homes.clear()
    await clone.carry(())
    assert [each.wanted for each in homes if each.node == "move_base"][-1] == "robot"
