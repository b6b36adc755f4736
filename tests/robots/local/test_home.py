"""The robot's home of nodes, in this process: what it is told, and what its nodes say."""

from collections.abc import Callable

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.maps.occupancy import to_message
from ppaas.messages import encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.std_msgs import Header
from robots.local import frames
from robots.local.home import LocalHome

MAP = msgspec.Raw(encode(to_message(office(seed=1, width=12.0, height=10.0))))
CONFIG = frames.CloneConfig("turtlebot2", (2.0, 2.0, 0.0), "dijkstra", "dwa")


@pytest.fixture
def told() -> list[frames.FromHome]:
    return []


@pytest.fixture
async def home(told: list[frames.FromHome]) -> LocalHome:
    return LocalHome(told.append)


def begin(home: LocalHome, config: frames.CloneConfig = CONFIG, grid: msgspec.Raw = MAP) -> None:
    home.take(frames.Begin(config, grid))


async def test_a_node_goes_on_here_and_goes_back_with_its_state(home: LocalHome, told: list[frames.FromHome]) -> None:
    begin(home)
    assert told == [frames.Ready()]
    state = '{"pose":[3.0,2.0,0.5],"covariance":[[0.1,0.0,0.0],[0.0,0.1,0.0],[0.0,0.0,0.1]],"odom":null}'
    home.take(frames.Add("amcl", state))
    added = told.pop()
    assert isinstance(added, frames.Added)
    assert frames.TopicName("scan", "sensor_msgs/LaserScan") in added.subscribes
    assert "amcl_pose" in added.publishes
    home.take(frames.AskStates())
    states = told.pop()
    assert isinstance(states, frames.States)
    assert states.nodes["amcl"].state == state
    home.take(frames.Remove("amcl"))
    assert told.pop() == frames.Removed("amcl", state)
    assert list(home.graph.nodes) == []


async def test_what_its_nodes_say_is_told_and_what_they_are_told_is_not(
    home: LocalHome, told: list[frames.FromHome]
) -> None:
    begin(home)
    home.take(frames.Add("move_base", ""))
    told.clear()
    pose = PoseWithCovariance(Pose.of(Pose2D(0.0, 0.0)))
    odometry = Odometry(Header(frame_id="odom"), "base_link", pose, TwistWithCovariance(Twist()))
    home.take(frames.Tell("odom", msgspec.Raw(encode(odometry))))
    assert told == []
    home.graph.publish("cmd_vel", Twist())
    assert told == [frames.Said("cmd_vel", "geometry_msgs/Twist", msgspec.Raw(encode(Twist())))]


async def test_a_message_that_cannot_be_taken_does_no_harm(
    home: LocalHome, told: list[frames.FromHome], caplog: pytest.LogCaptureFixture
) -> None:
    begin(home)
    home.take(frames.Add("move_base", ""))
    told.clear()
    home.take(frames.Tell("move_base/cancel", msgspec.Raw(b'{"id": 3}')))
    home.take(frames.Tell("nothing", msgspec.Raw(b"{}")))
    assert told == []
    assert "move_base/cancel was not taken" in caplog.text
    home.take(frames.Tell("move_base/cancel", msgspec.Raw(encode(GoalID(id="g")))))


@pytest.mark.parametrize(
    ("do", "slug", "text"),
    [
        (lambda home: begin(home, msgspec.structs.replace(CONFIG, model="snail")), "not-found", "snail"),
        (lambda home: begin(home, grid=msgspec.Raw(b"{}")), "malformed-message", "OccupancyGrid"),
        (lambda home: home.take(frames.Add("amcl", "")), "error", "there is no map yet"),
        (lambda home: home.take(frames.Remove("amcl")), "not-found", "amcl"),
        (lambda home: (begin(home), home.take(frames.Add("amcl", "rubbish"))), "error", "JSON"),
    ],
)
async def test_what_cannot_be_done_is_told(
    do: Callable[[LocalHome], object], slug: str, text: str, home: LocalHome, told: list[frames.FromHome]
) -> None:
    do(home)
    failed = told[-1]
    assert isinstance(failed, frames.Failed)
    assert failed.slug == slug
    assert text in failed.text
