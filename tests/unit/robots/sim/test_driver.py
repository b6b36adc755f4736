"""Driver of a simulated robot over a real socket."""

import asyncio
import base64
import math
from collections.abc import AsyncIterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import Velocity
from ppaas.errors import Conflict, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages import decode
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.perception.compressed_depth import decompress
from robots.client.robot_client import RobotClient
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.driver import Driver, FixedRate, SensorRates
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.world import World
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.waiting import until
from tests.support.world.rooms import room

START = Pose2D(2.5, 1.5, 0.7)


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


@pytest.fixture
def robot() -> SimulatedRobot:
    return World(room(4.0, 4.0), epoch=1000.0).add_robot(START)


async def test_the_driver_publishes_odometry_and_scans_but_not_the_true_pose(
    server: RosbridgeServer, robot: SimulatedRobot
) -> None:
    async with RobotClient(server.url, robot="tb1", token="t") as client:
        driving = asyncio.create_task(Driver(robot, client, SensorRates(odom=100.0, scan=50.0)).run())
        await until(lambda: sum(frame["topic"] == "scan" for frame in server.of("publish")) >= 5)
        driving.cancel()
    frames = server.of("publish")
    assert {frame["topic"] for frame in frames} == {"odom", "scan"}
    assert frames[0]["topic"] == "odom", "where the robot stood must be known when its scan arrives"
    odometry = decode(Odometry, str(frames[0]["msg"]).replace("'", '"'))
    assert odometry.pose.pose.planar() == Pose2D(0.0, 0.0, 0.0)
    scan = next(frame["msg"] for frame in frames if frame["topic"] == "scan")
    assert scan["header"]["frame_id"] == "base_link"
    assert len(scan["ranges"]) == 360
    assert set(scan) == set(LaserScan.__struct_fields__)


async def test_the_driver_follows_commands_and_ignores_invalid_ones(
    server: RosbridgeServer, robot: SimulatedRobot
) -> None:
    async with RobotClient(server.url, robot="tb1", token="t") as client:
        driver = Driver(robot, client)
        driving = asyncio.create_task(driver.run())
        await server.heard("subscribe")
        await server.say(op="publish", topic="cmd_vel", msg={"linear": {"x": 1e999}, "angular": {}})
        await server.say(op="publish", topic="cmd_vel", msg={"linear": {"x": 0.3}, "angular": {"z": -0.2}})
        await until(lambda: driver.commands)
        driving.cancel()
    for _ in range(10):
        robot.before_step()
        robot.base._turn_wheels(robot.base.body, (0.0, 0.0), 1.0, 0.05)
    assert robot.base.wheels == Velocity(0.3, -0.2)


async def test_the_driver_ends_with_the_reason_of_the_close(server: RosbridgeServer, robot: SimulatedRobot) -> None:
    async with RobotClient(server.url, robot="tb1", token="t") as client:
        driving = asyncio.create_task(Driver(robot, client).run())
        await server.heard("publish")
        await server.connections[-1].close(1011, "conflict: another one took over")
        with pytest.raises(Conflict, match="another one took over"):
            await asyncio.wait_for(driving, 10)


@pytest.mark.parametrize("compressed", [True, False])
async def test_a_robot_with_a_camera_publishes_its_mount_and_depth_images(
    server: RosbridgeServer, compressed: bool
) -> None:
    eye = DepthCameraModel(width=32, height=24)
    robot = World(room(4.0, 4.0), epoch=1000.0).add_robot(START, SimulatedRobotModel(camera=eye))
    topic = "camera/depth/image_raw" + "/compressedDepth" * compressed
    async with RobotClient(server.url, robot="tb1", token="t") as client:
        rates = SensorRates(depth=50.0)
        driving = asyncio.create_task(Driver(robot, client, rates, compressed=compressed).run())
        await until(lambda: sum(frame["topic"] == topic for frame in server.of("publish")) >= 3)
        driving.cancel()
    frames = {frame["topic"]: frame["msg"] for frame in server.of("publish")}
    assert set(frames) == {"odom", "scan", "tf_static", "camera/depth/camera_info", topic}
    assert [each["child_frame_id"] for each in frames["tf_static"]["transforms"]] == [
        "camera_depth_frame",
        "camera_depth_optical_frame",
    ]
    if compressed:
        image = decompress(frames[topic]["format"], base64.b64decode(frames[topic]["data"]))
    else:
        image = np.frombuffer(base64.b64decode(frames[topic]["data"]), "<u2").reshape(24, 32)
    assert image.shape == (24, 32)
    assert image.any()
    assert frames["camera/depth/camera_info"]["width"] == 32


@given(st.floats(0.5, 200.0), st.lists(st.floats(0.0, 1.0), min_size=1, max_size=40))
def test_a_schedule_keeps_its_rate_without_catching_up(rate: float, waits: list[float]) -> None:
    schedule, now, taken = FixedRate(rate, 10.0), 10.0, []
    for wait in waits:
        now += wait
        if schedule.take(now):
            taken.append(now)
            assert not schedule.take(now)
        assert now - FixedRate.SLACK < schedule.next <= now + 1.0 / rate + FixedRate.SLACK
    assert len(taken) <= (now - 10.0) * rate + 2


def test_a_schedule_does_not_drift() -> None:
    schedule, taken = FixedRate(20.0, 0.0), 0
    for millisecond in range(59_990):
        taken += schedule.take(millisecond / 1000.0)
    assert taken == 60 * 20


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf])
def test_an_invalid_rate_is_refused(rate: float) -> None:
    with pytest.raises(InvalidParameter, match="Hz"):
        SensorRates(scan=rate)
