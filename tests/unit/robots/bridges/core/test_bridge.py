"""The bridge between a graph in memory and a real WebSocket server."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from ppaas.wire.ros.graph import LATCHED, SENSOR, Kind
from robots.bridges.core import downward, findings
from robots.bridges.core.bridge import Bridge
from robots.bridges.core.tables import ACTIONS, DOWN, SERVICES
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.ros2.fake_transport import FakeTransport
from tests.support.waiting import until

CLONE = ["/odom", "/scan", "/tf", "/tf_static", "/goal_pose", "/initialpose", "/camera/depth/camera_info"]
ODOMETRY, SCAN, TF = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage"
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
GRID, UPDATE = "nav_msgs/msg/OccupancyGrid", "map_msgs/msg/OccupancyGridUpdate"
NAVIGATE = ACTIONS["navigate_to_pose"]
UUID = bytes(range(16))


class Both:
    """A bridge, its robot and its cloud."""

    def __init__(self, robot: FakeTransport, cloud: RosbridgeServer) -> None:
        self.robot, self.cloud = robot, cloud

    async def published(self, topic: str, count: int = 1) -> list[Any]:
        """Wait until the cloud has received messages of a topic, and return them."""

        def received() -> list[Any]:
            return [frame["msg"] for frame in self.cloud.of("publish") if frame["topic"] == topic]

        await until(lambda: len(received()) >= count)
        return received()

    async def subscribed(self, topic: str) -> None:
        await until(lambda: topic in [frame["topic"] for frame in self.cloud.of("subscribe")])

    async def heard(self, topic: str, count: int = 1) -> list[dict[str, Any]]:
        """Wait until the robot has received messages of a topic, and return them."""
        await until(lambda: len(self.robot.published.get(topic, [])) >= count)
        return self.robot.published[topic]


@asynccontextmanager
async def bridged(robot: FakeTransport, **options: Any) -> AsyncIterator[Both]:
    """Run a bridge to a cloud whose clone has the topics `CLONE`."""
    async with rosbridge_server() as cloud:
        running = asyncio.create_task(Bridge(robot, url=cloud.url, robot="tb1", token="t", **options).run())
        [asked] = await cloud.heard("call_service")
        assert asked["service"] == "rosapi/topics"
        await cloud.say(
            op="service_response",
            service="rosapi/topics",
            id=asked["id"],
            result=True,
            values={"topics": CLONE, "types": []},
        )
        try:
            yield Both(robot, cloud)
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
    assert not robot.opened
    assert not robot.publishers
    assert not robot.subscriptions
    assert not robot.servers


def turtlebot(namespace: str = "", *, base: str = TWIST) -> FakeTransport:
    robot = FakeTransport()
    robot.has(Kind.PUBLISHER, f"{namespace}/odom", ODOMETRY)
    robot.has(Kind.PUBLISHER, f"{namespace}/scan", SCAN, SENSOR)
    robot.has(Kind.PUBLISHER, f"{namespace}/tf_static", TF, LATCHED)
    robot.has(Kind.SUBSCRIBER, f"{namespace}/cmd_vel", base)
    return robot


def odometry(second: int) -> dict[str, Any]:
    return {"header": {"stamp": {"sec": second}, "frame_id": "odom"}, "child_frame_id": "base_link"}


async def test_sensors_go_up_as_the_cloud_reads_them() -> None:
    async with bridged(turtlebot("/tb3")) as both:
        await until(lambda: "/tb3/tf_static" in both.robot.subscriptions)
        assert both.robot.subscriptions["/tb3/scan"][1].reliable is False
        assert both.robot.subscriptions["/tb3/tf_static"][1].latched
        both.robot.say("/tb3/odom", odometry(5))
        both.robot.say("/tb3/scan", {"header": {"frame_id": "laser"}, "ranges": [1.0]})
        mount = {"header": {"frame_id": "base_link"}, "child_frame_id": "laser"}
        both.robot.say("/tb3/tf_static", {"transforms": [mount]})
        [static] = await both.published("tf_static")
        assert static["transforms"][0]["child_frame_id"] == "laser"
        both.robot.say("/tb3/scan", {"header": {"frame_id": "laser"}, "ranges": [2.0, float("inf")]})
        assert [scan["ranges"] for scan in await both.published("scan")] == [[2.0, None]], "the first came too early"
        assert (await both.published("odom"))[0]["header"]["stamp"] == {"sec": 5, "nanosec": 0}


async def test_a_robot_that_has_restarted_is_searched_on_the_whole_map(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    async with bridged(turtlebot()) as both:
        robot = both.robot
        await until(lambda: "/odom" in robot.subscriptions)
        robot.say("/odom", odometry(5) | {"pose": {"pose": {"position": {"x": 4.0}, "orientation": {"w": 1.0}}}})
        del robot.graph[0]
        robot.has(Kind.PUBLISHER, "/odom", ODOMETRY)
        robot.changed()
        robot.say("/odom", odometry(6))
        await until(lambda: len(both.cloud.of("call_service")) == 2)
        asked = both.cloud.of("call_service")[1]
        assert asked["service"] == "global_localization"
        failed = {"op": "service_response", "service": "global_localization", "id": asked["id"], "result": False}
        await both.cloud.say(**failed, values="invalid-map: no cell is free")
        await until(lambda: "no cell is free" in caplog.text)
        assert "the robot has restarted (restart 1)" in caplog.text


async def test_a_clone_that_begins_anew_is_told_what_the_last_one_knew(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    async with bridged(turtlebot()) as both:
        await until(lambda: "/tf_static" in both.robot.subscriptions)
        await both.subscribed("tf")
        mount = {"header": {"frame_id": "base_link"}, "child_frame_id": "laser"}
        both.robot.say("/tf_static", {"transforms": [mount]})
        both.robot.say("/odom", odometry(5) | {"pose": {"pose": {"position": {"x": 2.0}, "orientation": {"w": 1.0}}}})
        quarter = {"translation": {"x": 1.0, "y": 3.0}, "rotation": {"z": 0.5**0.5, "w": 0.5**0.5}}
        moved = {"header": {"frame_id": "map"}, "child_frame_id": "odom", "transform": quarter}
        await both.cloud.say(op="publish", topic="tf", msg={"transforms": [moved]})
        await both.heard("/tf")
        await both.cloud.connections[-1].close()
        [initial] = await both.published("initialpose")
        statics = await both.published("tf_static", 2)
        assert statics[0] == statics[1]
        pose = initial["pose"]["pose"]
        assert (pose["position"]["x"], pose["position"]["y"]) == (pytest.approx(1.0), pytest.approx(5.0))
        assert pose["orientation"]["z"] == pytest.approx(0.5**0.5)
        assert initial["header"]["frame_id"] == "map"


async def test_what_the_clone_does_not_have_is_left_with_the_robot() -> None:
    robot = turtlebot()
    robot.has(Kind.PUBLISHER, "/camera/depth/image_raw", "sensor_msgs/msg/Image", SENSOR)
    robot.has(Kind.PUBLISHER, "/battery_state", "sensor_msgs/msg/BatteryState", SENSOR)
    async with bridged(robot) as both:
        advertised = {frame["topic"]: frame["type"] for frame in await both.cloud.heard("advertise", 2)}
        assert advertised["battery_state"] == "sensor_msgs/msg/BatteryState"
        await until(lambda: "/battery_state" in robot.subscriptions)
        assert "/camera/depth/image_raw" not in robot.subscriptions
        robot.say("/battery_state", {"percentage": 0.5})
        robot.say("/battery_state", {"percentage": 0.4})
        robot.has(Kind.PUBLISHER, "/goal_pose", "geometry_msgs/msg/PoseStamped")
        robot.changed()
        await until(lambda: "/goal_pose" in robot.subscriptions)
        robot.say("/goal_pose", {"header": {"frame_id": "map"}})
        assert await both.published("goal_pose")
        assert len(await both.published("battery_state")) == 1, "one message a second is enough"


async def test_velocities_have_the_type_that_the_base_expects_and_end_with_the_cloud(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(downward, "SILENCE", 0.02)
    monkeypatch.setattr(downward, "ZERO_PERIOD", 0.01)
    async with bridged(turtlebot(base=STAMPED)) as both:
        await until(lambda: "/odom" in both.robot.subscriptions)
        both.robot.say("/odom", odometry(100))
        await both.cloud.say(op="publish", topic="cmd_vel", msg={"linear": {"x": 0.3}, "angular": {"z": 0.1}})
        commands = await both.heard("/cmd_vel", 1 + downward.ZEROS)
        assert commands[0]["header"]["frame_id"] == "base_link"
        assert commands[0]["header"]["stamp"]["sec"] == 100, "the clock is that of the robot"
        assert [command["twist"]["linear"]["x"] for command in commands] == [0.3] + [0.0] * downward.ZEROS


async def test_the_robot_stops_when_the_bridge_ends() -> None:
    robot = turtlebot()
    async with bridged(robot) as both:
        await until(lambda: any(one.topic == "/cmd_vel" for one in robot.publishers))
        await both.cloud.say(op="publish", topic="cmd_vel", msg={"linear": {"x": 0.3}, "angular": {}})
        await both.heard("/cmd_vel")
    assert [command["linear"]["x"] for command in robot.published["/cmd_vel"]] == [0.3, 0.0]


async def test_topics_of_the_clone_are_requested_while_somebody_subscribes_and_the_map_always() -> None:
    robot = turtlebot()
    async with bridged(robot) as both:
        await both.subscribed("map")
        await both.subscribed("tf")
        topics = {one.topic for one in robot.publishers if "_action" not in one.topic}
        assert topics == {"/tf", "/cmd_vel", *(f"/{topic.name}" for topic in DOWN)}
        assert "plan" not in [frame["topic"] for frame in both.cloud.of("subscribe")]
        reader = robot.has(Kind.SUBSCRIBER, "/plan", "nav_msgs/msg/Path")
        robot.has(Kind.SUBSCRIBER, "/particle_cloud", "nav2_msgs/msg/ParticleCloud")
        robot.changed()
        await both.subscribed("particlecloud")
        await both.cloud.say(op="publish", topic="particlecloud", msg={"header": {}, "poses": [{}, {}]})
        [particles] = await both.heard("/particle_cloud")
        assert [one["weight"] for one in particles["particles"]] == [0.5, 0.5]
        robot.graph.remove(reader)
        robot.changed()
        assert (await both.cloud.heard("unsubscribe"))[0]["topic"] == "plan"
        transforms = [
            {"header": {"frame_id": parent}, "child_frame_id": child, "transform": {}}
            for parent, child in (("map", "odom"), ("odom", "base_link"))
        ]
        await both.cloud.say(op="publish", topic="tf", msg={"transforms": transforms})
        [moved] = await both.heard("/tf")
        assert [one["child_frame_id"] for one in moved["transforms"]] == ["odom"]


async def test_a_late_reader_of_the_map_gets_it_with_its_updates() -> None:
    robot = turtlebot()
    robot.has(Kind.SUBSCRIBER, "/map_updates", UPDATE)
    async with bridged(robot) as both:
        await both.subscribed("map_updates")
        await both.subscribed("map")
        grid = {"header": {}, "info": {"width": 2, "height": 2}, "data": [0, 0, 0, 0]}
        await both.cloud.say(op="publish", topic="map", msg=grid)
        update = {"header": {}, "x": 1, "y": 0, "width": 1, "height": 2, "data": [100, -1]}
        await both.cloud.say(op="publish", topic="map_updates", msg=update)
        await both.heard("/map_updates")
        robot.has(Kind.SUBSCRIBER, "/map", GRID, LATCHED)
        robot.changed()
        grids = await both.heard("/map", 2)
        assert [one["data"].tolist() for one in grids] == [[0, 0, 0, 0], [0, 100, 0, -1]]
        await both.cloud.say(op="publish", topic="map_updates", msg=update | {"x": 2})
        await both.cloud.say(op="publish", topic="map", msg=grid)
        await both.heard("/map", 3)


async def test_services_of_nav2_are_those_of_the_clone() -> None:
    async with bridged(turtlebot("/a")) as both:
        await until(lambda: len(both.robot.servers) == len(SERVICES) + 3 * len(ACTIONS.keys() - {"follow_object"}))
        call = asyncio.create_task(both.robot.call("/a/map_server/map", {}))
        asked = (await both.cloud.heard("call_service", 2))[1]
        assert asked["service"] == "static_map"
        values = {"map": {"info": {"width": 3}}}
        await both.cloud.say(op="service_response", service="static_map", id=asked["id"], result=True, values=values)
        assert (await call)["map"]["info"]["width"] == 3


@pytest.mark.parametrize(("release", "package"), [("humble", "opennav_docking_msgs"), ("jazzy", "nav2_msgs")])
async def test_docks_are_offered_with_the_package_of_the_release(release: str, package: str) -> None:
    robot = FakeTransport(release)
    for topic, kind in (("/odom", ODOMETRY), ("/scan", SCAN)):
        robot.has(Kind.PUBLISHER, topic, kind)
    action = "/dock_robot/_action"
    async with bridged(robot) as both:
        await until(lambda: f"{action}/send_goal" in both.robot.servers)
        assert both.robot.servers[f"{action}/send_goal"][0] == f"{package}/action/DockRobot_SendGoal"
        request = {"goal_id": {"uuid": bytes(range(16))}, "goal": {"use_dock_id": True, "dock_id": "a"}}
        sending = asyncio.create_task(both.robot.call(f"{action}/send_goal", request))
        [sent] = await both.cloud.heard("send_action_goal")
        assert (sent["action"], sent["args"]["dock_id"]) == ("dock_robot", "a")
        feedback = {"state": 3, "docking_time": {"sec": 2, "nanosec": 0}, "num_retries": 1}
        await both.cloud.say(op="action_feedback", action=sent["action"], id=sent["id"], values=feedback)
        assert (await sending)["accepted"]
        assert (await both.heard(f"{action}/feedback"))[0]["feedback"]["num_retries"] == 1
        values = {"success": False, "error_code": 906, "num_retries": 3, "error_msg": "not charged"}
        await both.cloud.say(
            op="action_result", action=sent["action"], id=sent["id"], values=values, status=6, result=True
        )
        end = await both.robot.call(f"{action}/get_result", {"goal_id": request["goal_id"]})
        assert (end["status"], end["result"]["error_code"], end["result"]["num_retries"]) == (6, 906, 3)
        assert ("error_msg" in end["result"]) is (release != "humble")


async def test_a_goal_of_nav2_is_carried_with_feedback_cancel_and_result() -> None:
    action = "/navigate_to_pose/_action"
    async with bridged(turtlebot()) as both:
        await until(lambda: f"{action}/send_goal" in both.robot.servers)
        goal = {"pose": {"header": {"frame_id": "map"}}}
        request = {"goal_id": {"uuid": UUID}, "goal": goal}
        accepting = asyncio.create_task(both.robot.call(f"{action}/send_goal", request))
        [sent] = await both.cloud.heard("send_action_goal")
        assert (sent["action"], sent["action_type"]) == ("navigate_to_pose", NAVIGATE)
        assert sent["args"]["pose"]["header"]["frame_id"] == "map"
        feedback = {"distance_remaining": 2.5, "number_of_recoveries": 1}
        await both.cloud.say(op="action_feedback", action="navigate_to_pose", id=sent["id"], values=feedback)
        assert (await accepting)["accepted"]
        [heard] = await both.heard(f"{action}/feedback")
        assert (heard["goal_id"]["uuid"], heard["feedback"]["distance_remaining"]) == (UUID, 2.5)
        getting = asyncio.create_task(both.robot.call(f"{action}/get_result", {"goal_id": {"uuid": UUID}}))
        everything = {"goal_info": {"goal_id": {"uuid": bytes(16)}}}
        cancelled = await both.robot.call(f"{action}/cancel_goal", everything)
        assert [one["goal_id"]["uuid"] for one in cancelled["goals_canceling"]] == [UUID]
        assert await both.cloud.heard("cancel_action_goal")
        await both.cloud.say(
            op="action_result",
            action="navigate_to_pose",
            id=sent["id"],
            status=5,
            result=True,
            values={"error_code": 0, "error_msg": ""},
        )
        assert (await getting)["status"] == 5
        statuses = [
            one["status_list"][0]["status"]
            for one in both.robot.published[f"{action}/status"]
            if len(one["status_list"])
        ]
        assert statuses == [2, 3, 5]
        again = await both.robot.call(f"{action}/cancel_goal", {"goal_info": {"goal_id": {"uuid": UUID}}})
        unknown = await both.robot.call(f"{action}/cancel_goal", {"goal_info": {"goal_id": {"uuid": b"\1" * 16}}})
        assert (again["return_code"], unknown["return_code"]) == (3, 2)
        assert (await both.robot.call(f"{action}/get_result", {"goal_id": {"uuid": b"\1" * 16}}))["status"] == 0


async def test_a_goal_that_the_cloud_refuses_is_not_accepted() -> None:
    async with bridged(turtlebot()) as both:
        await until(lambda: "/follow_waypoints/_action/send_goal" in both.robot.servers)
        request = {"goal_id": {"uuid": UUID}, "goal": {}}
        accepting = asyncio.create_task(both.robot.call("/follow_waypoints/_action/send_goal", request))
        [sent] = await both.cloud.heard("send_action_goal")
        await both.cloud.say(
            op="action_result", action="a", id=sent["id"], status=0, result=False, values="invalid-input: no poses"
        )
        assert not (await accepting)["accepted"]


@pytest.fixture
def examined(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let bridges examine graphs at once, and often."""
    monkeypatch.setattr(findings, "MISSING_AFTER", 0.3)
    monkeypatch.setattr(findings, "PERIOD", 0.05)


@pytest.mark.usefixtures("examined")
async def test_a_graph_without_a_robot_is_told_with_the_domains_of_others(caplog: pytest.LogCaptureFixture) -> None:
    elsewhere = FakeTransport()
    elsewhere.others = (7,)
    async with bridged(elsewhere) as both:
        told = (await both.published("diagnostics"))[0]["status"]
        assert [(one["name"], one["level"]) for one in told] == [("bridge: robot", 2)]
        assert "no robot is found" in told[0]["message"]
        assert "robots are in domain 7, and the bridge in 0" in caplog.text
    two = turtlebot("/a")
    two.has(Kind.PUBLISHER, "/b/odom", ODOMETRY)
    async with bridged(two):
        await until(lambda: "known: /a, /b; name one by --namespace" in caplog.text)
    async with bridged(two, namespace="a") as both:
        await until(lambda: "/a/odom" in both.robot.subscriptions)


@pytest.mark.usefixtures("examined")
async def test_what_is_wrong_is_told_until_it_is_mended(caplog: pytest.LogCaptureFixture) -> None:
    blind = FakeTransport()
    blind.has(Kind.PUBLISHER, "/odom", ODOMETRY)
    async with bridged(blind) as both:
        await until(lambda: "/odom" in blind.subscriptions)
        blind.subscriptions["/odom"][2](b"\0\1\0\0?")
        first = {one["name"]: one for one in (await both.published("diagnostics"))[0]["status"]}
        assert set(first) == {"bridge: scan", "bridge: cmd_vel", "bridge: warning 1"}
        assert "does not publish 'scan'" in first["bridge: scan"]["message"]
        assert "cannot be read" in first["bridge: warning 1"]["message"]
        assert "no base subscribes" in caplog.text
        blind.has(Kind.PUBLISHER, "/scan", SCAN)
        blind.changed()

        def mended() -> bool:
            arrays = [frame["msg"]["status"] for frame in both.cloud.of("publish") if frame["topic"] == "diagnostics"]
            return any({"level": 0, "name": "bridge: scan", "message": ""} in array for array in arrays)

        await until(mended)


async def test_bytes_that_are_no_message_do_not_end_the_bridge(caplog: pytest.LogCaptureFixture) -> None:
    async with bridged(turtlebot()) as both:
        await until(lambda: "/tf_static" in both.robot.subscriptions)
        for topic in ("/odom", "/tf_static"):
            both.robot.subscriptions[topic][2](b"\0\1\0\0?")
        assert "'odom' cannot be read" in caplog.text
        await both.cloud.say(op="publish", topic="map", msg=json.loads('{"info": 3}'))
        await until(lambda: "'map' cannot be sent" in caplog.text)
        both.robot.say("/odom", odometry(1))
        await both.published("odom")


async def test_what_the_robots_ros_has_no_types_for_is_not_offered(caplog: pytest.LogCaptureFixture) -> None:
    robot = turtlebot()
    robot.packages_missing = {"nav2_msgs", "tf2_msgs"}
    async with bridged(robot) as both:
        await until(lambda: "'navigate_to_pose', " in caplog.text)
        await until(lambda: "/odom" in robot.subscriptions)
        assert set(robot.servers) == {f"/{service.name}" for service in SERVICES if "nav2_msgs" not in service.type}
        assert "/tf_static" not in robot.subscriptions
        assert not {"/tf", "/particle_cloud"} & {one.topic for one in robot.publishers}
        await both.subscribed("map")
