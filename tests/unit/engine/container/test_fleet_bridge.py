"""Fleet bridge: positions and plans that a clone shares, and positions that it receives."""

import logging
from collections.abc import AsyncIterator

import numpy as np
import pytest
from msgspec.structs import replace

from engine.container.fleet_bridge import FRESH, SHARE_PERIOD, TELL_PERIOD, FleetBridge, plan_record
from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, Launch
from ppaas.clock import ManualClock
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import TrafficReport
from ppaas.messages.geometry_msgs import (
    Point,
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.ppaas_msgs import RobotState
from ppaas.nodes import topics
from ppaas.nodes.base import Node, Topic
from ppaas.nodes.graph import Graph
from ppaas.planners.base import PlanResult
from ppaas.plans.reuse.processor import PlanIds
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import HOUSE, mapping_spec, robot_spec
from tests.support.world.echo_node import EchoNode


def pose(x: float, w: float = 1.0, frame: str = "map") -> PoseWithCovarianceStamped:
    where = Pose(Point(x, 0.0), Quaternion(x=0.0, y=0.0, z=0.0, w=w))
    return PoseWithCovarianceStamped(Header(frame_id=frame), PoseWithCovariance(where))


def continuing_spec() -> ContainerSpec:
    """Return the spec of a robot that continues a published map."""
    spec = mapping_spec()
    assert spec.robot is not None
    return replace(spec, robot=replace(spec.robot, continued=HOUSE))


def state(x: float, twist: Twist | None = None, frame: str = "map") -> RobotState:
    """Return the shared state of a TurtleBot."""
    stamped = pose(x, frame=frame)
    return RobotState(stamped.header, stamped.pose, twist or Twist(), 0.18)


def shared(who: str, payload: bytes, topic: str = "amcl_pose") -> machine_link.Shared:
    return machine_link.Shared(who, "tb1", topic, payload)


def plan(*points: tuple[float, float], planner: str = "dijkstra") -> PlanResult:
    poses = np.array([[x, y, 0.0, 0.0, 0.0, 0.0, 1.0] for x, y in points]).reshape(-1, 7)
    found = PlanResult(np.zeros((len(points), 2), np.int32), poses, 50.0, 1.0, 9, 0.01, planner)
    return replace(found, id=PlanIds("house", "v1", planner, {}).of(found))


LAUNCH = Launch(robot_spec("c1", "ann", "tb1"), "", "", "", "secret", (0,), 1)


class Wheels(Node):
    """Node that subscribes to odometry, as the nodes of a clone do."""

    name = "wheels"
    subscribes = (Topic("odom", Odometry),)


class Mapper(Node):
    """Node that publishes poses in the frame of a published map, as ``grid_slam`` does."""

    name = "grid_slam"
    publishes = (topics.SHARED_POSE,)


class Driver(Node):
    """Node that reports to a traffic node."""

    name = "driver"
    publishes = (topics.TRAFFIC_REPORT,)


class Clone:
    """Graph with a node that receives other robots, and the machine's end of its link."""

    def __init__(
        self, client: MachineClient, machine: FrameStream[machine_link.FromContainer], launch: Launch = LAUNCH
    ) -> None:
        self.clock = ManualClock(1000.0)
        self.set_by = 0.0
        self.graph = Graph(clock=self.clock, stamp_clock=lambda: self.clock() + self.set_by)
        self.node = self.graph.add(EchoNode)
        self.graph.add(Wheels)
        self.graph.add(Mapper)
        self.graph.add(Driver)
        self.machine = machine
        self.here = True
        self.outside = FleetBridge(launch, self.graph, client, lambda: self.here)

    def seen(self) -> list[float]:
        """Return the other robots of the last message to the clone."""
        return sorted(p.position.x for p in self.node.robots[-1].poses)


@pytest.fixture
async def clone() -> AsyncIterator[Clone]:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    yield Clone(client, far)
    await client.close()
    await far.close()


async def test_positions_are_shared_at_a_limited_rate(clone: Clone) -> None:
    for step in range(3):
        clone.graph.publish("amcl_pose", pose(float(step)))
        clone.clock.advance(SHARE_PERIOD * 0.6)
    frames = [await receive(clone.machine) for _ in range(2)]
    assert frames == [machine_link.FabricPublish("amcl_pose", encode(state(x))) for x in (0.0, 2.0)]


async def test_no_position_of_a_robot_that_is_away_is_shared(clone: Clone) -> None:
    clone.here = False
    clone.graph.publish("amcl_pose", pose(0.0))
    clone.here = True
    clone.graph.publish("amcl_pose", pose(1.0))
    assert await receive(clone.machine) == machine_link.FabricPublish("amcl_pose", encode(state(1.0)))


async def test_a_robot_that_makes_a_map_shares_neither_positions_nor_plans() -> None:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    clone = Clone(client, far, replace(LAUNCH, spec=mapping_spec()))
    clone.graph.publish("amcl_pose", pose(0.0))
    clone.graph.publish("plan", plan((0.0, 0.0), (1.0, 0.0)))
    client.share("end", b"")
    assert await receive(far) == machine_link.FabricPublish("end", b"")
    await client.close()
    await far.close()


async def test_a_robot_that_continues_a_map_shares_the_positions_in_its_frame() -> None:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    clone = Clone(client, far, replace(LAUNCH, spec=continuing_spec()))
    clone.graph.publish("grid_slam/shared_pose", pose(2.0))
    assert await receive(far) == machine_link.FabricPublish("amcl_pose", encode(state(2.0)))
    clone.outside.shared(shared("bob", encode(state(1.0))))
    assert clone.seen() == [1.0]
    clone.clock.advance(FRESH)
    clone.outside.shared(shared("bob", encode(state(3.0))))
    assert clone.seen() == [1.0]
    await client.close()
    await far.close()


async def test_robots_whose_maps_are_joined_receive_each_other() -> None:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    clone = Clone(client, far, replace(LAUNCH, spec=mapping_spec()))
    clone.graph.publish("grid_slam/shared_pose", pose(2.0, frame="map_1"))
    assert await receive(far) == machine_link.FabricPublish("amcl_pose", encode(state(2.0, frame="map_1")))
    clone.outside.shared(shared("bob", encode(state(1.0, frame="map_2"))))
    assert not clone.node.robots
    clone.clock.advance(SHARE_PERIOD)
    clone.graph.publish("grid_slam/shared_pose", pose(2.5, frame="map_2"))
    clone.outside.shared(shared("bob", encode(state(1.0, frame="map_2"))))
    assert clone.seen() == [1.0]
    await client.close()
    await far.close()


async def test_robot_that_left_the_published_map_shares_nothing_with_the_robots_on_it() -> None:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client = MachineClient(near)
    clone = Clone(client, far, replace(LAUNCH, spec=continuing_spec()))
    clone.graph.publish("grid_slam/shared_pose", pose(2.0, frame="map_1"))
    client.share("end", b"")
    assert await receive(far) == machine_link.FabricPublish("end", b"")
    await client.close()
    await far.close()


async def test_position_is_shared_with_its_recent_velocity(clone: Clone) -> None:
    twist = Twist(linear=Vector3(x=0.4), angular=Vector3(z=0.1))
    clone.graph.inject("odom", Odometry(Header(), "base_link", pose(0.0).pose, TwistWithCovariance(twist)))
    clone.graph.publish("amcl_pose", pose(1.0))
    assert await receive(clone.machine) == machine_link.FabricPublish("amcl_pose", encode(state(1.0, twist)))
    clone.clock.advance(2.0 * FRESH)
    clone.graph.publish("amcl_pose", pose(1.0))
    assert await receive(clone.machine) == machine_link.FabricPublish("amcl_pose", encode(state(1.0)))


async def test_clone_receives_velocities_and_radii_of_other_robots(clone: Clone) -> None:
    clone.outside.shared(shared("bob", encode(state(1.0, Twist(linear=Vector3(x=0.4))))))
    robots = clone.node.robots[-1]
    assert (robots.twists[0].linear.x, robots.radii) == (0.4, [0.18])


@pytest.mark.parametrize(("fields", "granted"), [({}, True), ({"free": True}, False), ({"stray": True}, False)])
async def test_a_robot_is_granted_while_its_reports_are_recent_and_neither_free_nor_stray(
    clone: Clone, fields: dict[str, bool], granted: bool
) -> None:
    report = TrafficReport(Header(frame_id="map"), "tb1", 1, 0.0, 0.0, 0.0, 0.2, 0.5, 0.3, **fields)
    clone.graph.publish("traffic/report", report)
    clone.graph.publish("amcl_pose", pose(1.0))
    wanted = replace(state(1.0), granted=granted)
    assert await receive(clone.machine) == machine_link.FabricPublish("amcl_pose", encode(wanted))
    clone.clock.advance(FRESH)
    clone.graph.publish("amcl_pose", pose(1.0))
    assert await receive(clone.machine) == machine_link.FabricPublish("amcl_pose", encode(state(1.0)))


async def test_clone_receives_which_robots_of_its_own_user_are_granted(clone: Clone) -> None:
    granted = replace(state(1.0), granted=True)
    clone.outside.shared(shared("bob", encode(granted)))
    assert clone.node.robots[-1].granted == [], "what other users' robots say does not count"
    for robot, one in (("tb2", granted), ("tb3", state(3.0))):
        clone.clock.advance(TELL_PERIOD)
        clone.outside.shared(machine_link.Shared("ann", robot, "amcl_pose", encode(one)))
    assert clone.node.robots[-1].granted == [False, True, False]


async def test_positions_are_shared_after_the_clock_is_set_back(clone: Clone) -> None:
    for x in (0.0, 1.0):
        clone.graph.publish("amcl_pose", pose(x))
        clone.clock.advance(SHARE_PERIOD)
        clone.set_by -= 60.0
    frames = [await receive(clone.machine) for _ in range(2)]
    assert frames == [machine_link.FabricPublish("amcl_pose", encode(state(x))) for x in (0.0, 1.0)]


async def test_clone_receives_recently_seen_robots_only(clone: Clone) -> None:
    clone.outside.shared(shared("bob", encode(pose(1.0))))
    clone.clock.advance(FRESH * 0.6)
    clone.outside.shared(shared("eve", encode(pose(2.0))))
    assert clone.seen() == [1.0, 2.0]
    clone.clock.advance(FRESH * 0.6)
    clone.outside.shared(shared("eve", encode(pose(3.0))))
    assert clone.seen() == [3.0]
    assert clone.node.robots[-1].header.frame_id == "map"


@pytest.mark.parametrize("by", [-3600.0, 3600.0])
async def test_robots_are_forgotten_after_a_time_whatever_the_clock_is_set_to(clone: Clone, by: float) -> None:
    clone.outside.shared(shared("bob", encode(pose(1.0))))
    clone.set_by = by
    clone.clock.advance(FRESH * 0.6)
    clone.outside.shared(shared("eve", encode(pose(2.0))))
    assert clone.seen() == [1.0, 2.0]
    clone.clock.advance(FRESH * 0.6)
    clone.outside.shared(shared("eve", encode(pose(3.0))))
    assert clone.seen() == [3.0]


async def test_message_rate_does_not_grow_with_the_number_of_robots(clone: Clone) -> None:
    for number in range(8):
        clone.outside.shared(shared(f"u{number}", encode(pose(float(number)))))
    assert len(clone.node.robots) == 1
    clone.clock.advance(TELL_PERIOD)
    clone.outside.shared(shared("u0", encode(pose(0.0))))
    assert clone.seen() == [float(number) for number in range(8)]


async def test_positions_of_a_batch_are_told_at_once_without_the_robot_itself(clone: Clone) -> None:
    batch = [shared("bob", encode(pose(1.0))), shared("ann", encode(pose(2.0))), shared("eve", encode(pose(3.0)))]
    clone.outside.shared(*batch)
    assert len(clone.node.robots) == 1
    assert clone.seen() == [1.0, 3.0]


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"{",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"header":{},"pose":{"pose":{"position":{"x":1e999},"orientation":{}}}}',
        encode(pose(float("nan"))),
        encode(pose(9.0, w=0.0)),
        encode(replace(state(9.0), radius=-1.0)),
        b'{"header":{},"pose":{"pose":{"position":{"x":9},"orientation":{"w":1}}},"twist":{"linear":{"x":1e999}}}',
    ],
    ids=[
        "nothing",
        "cut off",
        "no text",
        "bottomless",
        "beyond all numbers",
        "nan",
        "no orientation",
        "no size",
        "no speed",
    ],
)
async def test_invalid_positions_are_dropped_and_logged_once(
    clone: Clone, payload: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    clone.outside.shared(shared("bob", encode(pose(1.0))))
    for _ in range(3):
        clone.outside.shared(shared("eve", payload))
    clone.clock.advance(TELL_PERIOD)
    clone.outside.shared(shared("ian", encode(pose(2.0))))
    assert clone.seen() == [1.0, 2.0]
    assert len([record for record in caplog.records if record.levelno >= logging.WARNING]) == 1


async def test_other_topics_are_not_read_as_positions(clone: Clone) -> None:
    clone.outside.shared(shared("eve", b"{", topic="scan"))
    assert clone.node.robots == []


async def test_plan_is_stored_in_the_name_of_its_robot(clone: Clone) -> None:
    made = replace(plan((0.0, 0.0), (1.0, 2.0)), conditions={"smooth": True})
    clone.graph.publish("plan", made)
    keep = await receive(clone.machine)
    assert isinstance(keep, machine_link.KeepPlan)
    kept = keep.plan
    assert (kept.user, kept.robot, kept.map, kept.version) == ("ann", "tb1", "house", "v1")
    assert (kept.id, kept.parameters, kept.origin) == (made.id, {"smooth": True}, "computed")
    assert (kept.start, kept.goal, kept.created) == ((0.0, 0.0, 0.0), (1.0, 2.0, 0.0), 1000.0)
    np.testing.assert_array_equal(np.frombuffer(kept.poses).reshape(-1, 7)[:, :2], [(0.0, 0.0), (1.0, 2.0)])


async def test_empty_plan_is_not_stored(clone: Clone) -> None:
    clone.graph.publish("plan", plan())
    clone.graph.publish("plan", plan((0.0, 0.0), (3.0, 0.0)))
    keep = await receive(clone.machine)
    assert isinstance(keep, machine_link.KeepPlan)
    assert keep.plan.goal == (3.0, 0.0, 0.0)


async def test_reused_plan_is_not_stored_again(clone: Clone) -> None:
    clone.graph.publish("plan", replace(plan((0.0, 0.0), (1.0, 2.0)), id="p1", origin="reused", reused="p1"))
    clone.graph.publish("plan", replace(plan((0.0, 0.0), (3.0, 0.0)), id="p2", origin="stitched", reused="p1"))
    keep = await receive(clone.machine)
    assert isinstance(keep, machine_link.KeepPlan)
    assert (keep.plan.id, keep.plan.origin) == ("p2", "stitched")


def test_equal_plans_have_equal_ids_and_others_differ() -> None:
    first = plan_record(LAUNCH, plan((0.0, 0.0), (1.0, 2.0)), 1.0)
    again = plan_record(LAUNCH, plan((0.0, 0.0), (1.0, 2.0)), 2.0)
    others = [plan((0.0, 0.0), (1.0, 2.5)), plan((0.0, 0.0), (1.0, 2.0), planner="other")]
    assert again.id == first.id
    assert len({first.id, *(plan_record(LAUNCH, other, 1.0).id for other in others)}) == 3
