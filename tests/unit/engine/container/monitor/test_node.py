"""The node monitor: leases of nodes, and their return when the robot is lost."""

from collections.abc import Mapping, Sequence

import pytest

from engine.container.monitor import node as monitor
from engine.container.monitor.leases import MOST
from engine.container.monitor.measurements import TopicRates
from engine.container.monitor.node import MAX_PROBE, MAX_STATE, NodeMonitorNode
from engine.container.monitor.parameters import NodeMonitorParameters
from ppaas.change_log import LogChange, LogEntry
from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.messages import decode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.health.stops import StopState
from ppaas.messages.ppaas_msgs import (
    GiveNodeRequest,
    HoldNodeRequest,
    HoldNodeResponse,
    LogPart,
    NodeHome,
    NodeHomes,
    ProbeLinkRequest,
    ProbeLinkResponse,
    RunNodeRequest,
    TellRobotRequest,
    TellRobotResponse,
    TopicMessage,
)
from ppaas.nodes.base import Demands, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.message_checks import fingerprint
from ppaas.nodes.topic_bus import Tap

STRONG = TellRobotRequest(8, 3.0, 5.0, 0.3, 100e3, ["driver", "locator"])
WEAK = TellRobotRequest(4, 1.5, 1.0, 0.3, 100e3, ["driver", "locator"])


class FakeSwitch:
    """Switch of three nodes, one of which stays in the cloud; records its calls."""

    config = '{"model": "turtlebot2"}'

    def __init__(self) -> None:
        self.here = {"driver": "{}", "locator": '{"x":1}', "map_server": ""}
        self.done: list[tuple[str, str]] = []
        self.times: dict[str, float] = {}
        self.broken = False
        self.logs: dict[str, LogChange] = {}
        self.restored: dict[str, list[LogEntry]] = {}
        self.came: dict[str, Tap] = {}
        self.told: list[tuple[str, str]] = []

    def nodes(self) -> Mapping[str, Demands | None]:
        return {"driver": Demands(0.6, rates={"scan": 80e3}), "locator": Demands(0.1), "map_server": None}

    def take_out(self, node: str, came: Tap) -> str:
        self.done.append(("out", node))
        self.came[node] = came
        return self.here.pop(node)

    def whole_log(self, node: str) -> LogChange | None:
        return self.logs.get(node)

    def put_in(self, node: str, state: str, log: Sequence[LogEntry] = ()) -> None:
        self.done.append(("in", node))
        self.here[node] = state
        self.restored[node] = list(log)
        if self.broken:
            raise InvalidInput("no state")

    def tell(self, node: str, message: TopicMessage) -> None:
        self.told.append((node, decode(GoalID, message.message.encode()).id))

    def run_times(self) -> Mapping[str, float]:
        return self.times


class Cloud:
    """Graph with a node monitor, and a client of its services."""

    def __init__(self, parameters: NodeMonitorParameters | None = None, state: bytes | None = None) -> None:
        self.clock = ManualClock()
        self.hands = FakeSwitch()
        self.rates = TopicRates()
        self.epoch = 1000.0
        self.graph = Graph(clock=self.clock, stamp_clock=lambda: self.epoch + self.clock())
        self.node = self.graph.add(
            lambda context: NodeMonitorNode(context, self.hands, self.rates, parameters or NodeMonitorParameters())
        )
        if state is not None:
            self.node.restore(state)

    def ask(self, service: str, request: Message) -> Payload:
        answers: list[Payload | PPaaSError] = []
        self.graph.call(f"node_monitor/{service}", request, answers.append)
        [answer] = answers
        if isinstance(answer, PPaaSError):
            raise answer
        return answer

    def run_node(self, node: str, home: str = "") -> NodeHome:
        answer = self.ask("run_node", RunNodeRequest(node, home))
        assert isinstance(answer, NodeHome)
        return answer

    def hold(self, node: str, lease: int = 0, **report: object) -> HoldNodeResponse:
        answer = self.ask("hold_node", HoldNodeRequest(node, lease, **report))  # type: ignore[arg-type]
        assert isinstance(answer, HoldNodeResponse)
        return answer

    def homes(self) -> dict[str, str]:
        homes = self.graph.latched("node_monitor/homes")
        assert isinstance(homes, NodeHomes)
        assert homes == self.ask("list_nodes", Empty())
        return {node.node: node.home for node in homes.nodes}

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.5)):
            self.clock.advance(0.5)
            self.graph.run_due()


@pytest.fixture
def cloud() -> Cloud:
    return Cloud()


def test_nodes_run_in_the_cloud_until_a_robot_reports_itself(cloud: Cloud) -> None:
    assert cloud.homes() == {"driver": "cloud", "locator": "cloud", "map_server": "cloud"}
    answer = cloud.run_node("driver")
    assert (answer.home, answer.wanted, answer.reasons) == (
        "cloud", "cloud", ["the robot has not reported a computer to run nodes on"]
    )  # fmt: skip


def test_weak_robot_gets_no_node(cloud: Cloud) -> None:
    assert cloud.ask("tell_robot", WEAK) == TellRobotResponse('{"model": "turtlebot2"}', 4.0)
    answer = cloud.run_node("driver")
    assert answer.wanted == "cloud"
    assert "the robot is weak" in answer.reasons[0]
    with pytest.raises(Unavailable, match="the wanted home of driver is the cloud"):
        cloud.hold("driver")
    assert cloud.hands.done == []


def test_strong_robot_gets_the_node_with_its_state(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    answer = cloud.run_node("locator")
    assert (answer.home, answer.wanted) == ("cloud", "robot")
    taken = cloud.hold("locator")
    assert taken.state == '{"x":1}'
    assert taken.lease > 0
    assert cloud.homes()["locator"] == "robot"
    assert "locator" not in cloud.hands.here


def test_silent_robot_loses_its_node_to_the_cloud(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    lease = cloud.hold("driver").lease
    for n in range(10):
        assert cloud.hold("driver", lease, state=f'{{"n":{n}}}').lease == lease
        cloud.wait(2.0)
    assert cloud.homes()["driver"] == "robot"
    cloud.wait(2.0)
    assert cloud.homes()["driver"] == "cloud"
    assert cloud.hands.here["driver"] == '{"n":9}'
    assert cloud.hold("driver", lease, state="{}").lease == 0, "a robot that returns late no longer holds it"
    assert cloud.hands.here["driver"] == '{"n":9}'


def test_node_that_failed_on_the_robot_stays_in_the_cloud_for_a_while(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    lease = cloud.hold("driver").lease
    back = cloud.ask("give_node", GiveNodeRequest("driver", lease, '{"n":1}', "it was killed"))
    assert isinstance(back, NodeHome)
    assert (back.home, back.reasons) == ("cloud", ["it could not be run on the robot: it was killed"])
    assert cloud.hands.here["driver"] == '{"n":1}'
    assert cloud.run_node("driver").wanted == "cloud"
    assert cloud.run_node("driver", "robot").wanted == "robot"
    cloud.wait(31.0)
    assert cloud.run_node("driver").wanted == "robot"


@pytest.mark.parametrize(
    ("asked_back", "reason"), [(False, "the robot gave it back"), (True, "a client requested this home")]
)
def test_returned_node_states_the_reason(cloud: Cloud, asked_back: bool, reason: str) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver", "robot")
    lease = cloud.hold("driver").lease
    if asked_back:
        cloud.run_node("driver", "cloud")
    back = cloud.ask("give_node", GiveNodeRequest("driver", lease, "{}"))
    assert back == NodeHome("driver", "cloud", "cloud", 1.0, [reason])
    assert cloud.run_node("driver").wanted == "robot", "it did not fail there"


def test_robot_that_reports_a_failure_gets_no_node(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    cloud.ask("give_node", GiveNodeRequest("driver", 0, failure="no numba"))
    assert cloud.hands.done == []
    assert cloud.run_node("driver").reasons == ["it could not be run on the robot: no numba"]


@pytest.mark.parametrize("by", [-3600.0, 3600.0])
def test_leases_last_as_long_whatever_the_clock_is_set_to(cloud: Cloud, by: float) -> None:
    lease = lent(cloud)
    cloud.epoch += by
    cloud.wait(0.5)
    assert cloud.homes()["driver"] == "robot"
    assert cloud.hold("driver", lease, state="{}").lease == lease
    cloud.wait(10.0)
    assert cloud.homes()["driver"] == "cloud"


def test_a_recalled_node_continues_here_until_the_robot_takes_it_again(cloud: Cloud) -> None:
    lease = lent(cloud)
    cloud.hold("driver", lease, state='{"at":3}')
    cloud.node.recall("its map was replaced")
    assert cloud.hands.done[-1] == ("in", "driver")
    assert cloud.hands.here["driver"] == '{"at":3}'
    assert cloud.homes()["driver"] == "cloud"
    assert cloud.hold("driver", lease).lease == 0
    assert cloud.hold("driver").lease == lease + 1


def test_expired_lease_cannot_give_a_node_back(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    old = cloud.hold("driver").lease
    new = cloud.hold("driver").lease
    assert new != old, "a restarted robot gets a new lease"
    cloud.ask("give_node", GiveNodeRequest("driver", old, "{}"))
    assert cloud.homes()["driver"] == "robot"


def test_other_nodes_on_the_robot_count_against_its_power(cloud: Cloud) -> None:
    cloud.ask("tell_robot", TellRobotRequest(1, 1.5, 1.0, 0.3, 100e3, ["driver", "locator"]))
    cloud.run_node("locator", "robot")
    cloud.hold("locator")
    assert (
        "driver takes 0.60 cores of a Raspberry Pi 4, and the robot has 0.60 left"
        not in cloud.run_node("driver").reasons
    )
    cloud.ask("tell_robot", TellRobotRequest(1, 1.5, 0.98, 0.3, 100e3, ["driver", "locator"]))
    assert "and the robot has 0.59 left" in cloud.run_node("driver").reasons[0]


def test_leases_survive_a_replacement_of_the_container(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    lease = cloud.hold("driver").lease
    cloud.hold("driver", lease, state='{"n":5}')
    after = Cloud(state=cloud.node.checkpoint())
    assert after.hands.done == [("out", "driver")]
    assert after.hold("driver", lease).lease == lease
    after.wait(4.0)
    assert after.hands.here["driver"] == '{"n":5}'


def test_node_with_an_unreadable_state_restarts_in_the_cloud(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    cloud.hands.broken = True
    cloud.ask("give_node", GiveNodeRequest("driver", cloud.hold("driver").lease, "rubbish"))
    assert cloud.homes()["driver"] == "cloud"


def test_measured_times_appear_in_the_next_verdict(cloud: Cloud) -> None:
    by = NodeMonitorParameters(priorities=("node_properties",))
    cloud = Cloud(by)
    cloud.ask("tell_robot", STRONG)
    cloud.hands.times = {"driver": 0.004}
    cloud.wait(1.0)
    cloud.run_node("driver", "robot")
    lease = cloud.hold("driver").lease
    for _ in range(3):
        cloud.hold("driver", lease, seconds=0.01, rtt=0.1)
    assert "it takes 10 ms on the robot, and 104 ms in the cloud" in cloud.run_node("driver").reasons[0]


def test_measured_data_rates_appear_in_the_next_verdict() -> None:
    cloud = Cloud(NodeMonitorParameters(priorities=("network_bandwidth",)))
    cloud.ask("tell_robot", TellRobotRequest(4, 3.0, 2.0, 0.001, 1e6, ["driver"]))
    assert "its topics would use 80 KB/s of a link with 1000 KB/s" in cloud.run_node("driver").reasons[0]
    cloud.wait(0.5)
    cloud.rates.note("scan", 2_000_000)
    cloud.wait(5.0)
    answer = cloud.run_node("driver")
    assert "its topics would use 400 KB/s" in answer.reasons[0]
    assert answer.score < 0.5


@pytest.mark.parametrize(
    ("service", "request_", "error", "match"),
    [
        ("run_node", RunNodeRequest("nothing"), NotFound, "unknown node 'nothing'; known: driver"),
        ("run_node", RunNodeRequest("driver", "moon"), InvalidInput, "a home is 'cloud' or 'robot'"),
        ("hold_node", HoldNodeRequest("nothing"), NotFound, "unknown node"),
        ("give_node", GiveNodeRequest("nothing", 0), NotFound, "unknown node"),
        ("tell_robot", TellRobotRequest(0, 1.5, 1.0, 0.1, 1e6), InvalidInput, "cores must be a positive number"),
        ("tell_robot", TellRobotRequest(4, 1.5, 1.0, -0.1, 1e6), InvalidInput, "rtt must be a positive number"),
        ("probe_link", ProbeLinkRequest(MAX_PROBE + 1), InvalidInput, "a probe has up to 1048576 bytes"),
    ],
)
def test_invalid_requests_are_refused(
    cloud: Cloud, service: str, request_: Message, error: type[PPaaSError], match: str
) -> None:
    with pytest.raises(error, match=match):
        cloud.ask(service, request_)


def test_oversized_state_is_refused(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver")
    lease = cloud.hold("driver").lease
    with pytest.raises(InvalidInput, match="the state of a node may have"):
        cloud.hold("driver", lease, state="x" * (MAX_STATE + 1))


def test_probe_has_the_requested_size(cloud: Cloud) -> None:
    assert cloud.ask("probe_link", ProbeLinkRequest(1000)) == ProbeLinkResponse("0" * 1000)


def test_cloud_only_node_stays_in_the_cloud_on_request(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    answer = cloud.run_node("map_server", "robot")
    assert (answer.wanted, answer.reasons) == ("cloud", ["map_server stays in the cloud"])


def lent(cloud: Cloud) -> int:
    """Hand a node to the robot; return the lease."""
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver", "robot")
    return cloud.hold("driver").lease


def came(cloud: Cloud, *names: str) -> list[str]:
    """Send cancels for the node that is away; return their fingerprints."""
    for name in names:
        cloud.hands.came["driver"]("move_base/cancel", GoalID(id=name))
    return [fingerprint("move_base/cancel", GoalID(id=name)) for name in names]


def names(messages: list[TopicMessage]) -> list[str]:
    return [decode(GoalID, message.message.encode()).id for message in messages]


def test_unheard_messages_are_resent_until_the_state_includes_them(cloud: Cloud) -> None:
    lease = lent(cloud)
    a, _ = came(cloud, "a", "b")
    assert names(cloud.hold("driver", lease, state="{}").unheard) == ["a", "b"]
    assert names(cloud.hold("driver", lease, state="{}", heard=[a]).unheard) == ["b"]
    assert names(cloud.hold("driver", lease, state="{}", heard=["another"]).unheard) == ["b"]


def test_unheard_messages_are_delivered_when_the_node_returns(cloud: Cloud) -> None:
    lease = lent(cloud)
    a, b, _ = came(cloud, "a", "b", "c")
    cloud.hold("driver", lease, state='{"with":"a"}', heard=[a])
    cloud.ask("give_node", GiveNodeRequest("driver", lease, '{"with":"b"}', "killed", [b]))
    assert cloud.hands.here["driver"] == '{"with":"b"}'
    assert cloud.hands.told == [("driver", "c")]


def test_messages_for_a_lost_robot_are_delivered_to_its_node(cloud: Cloud) -> None:
    lent(cloud)
    came(cloud, "a")
    cloud.wait(4.0)
    assert cloud.hands.told == [("driver", "a")]


def test_unheard_messages_survive_a_replacement_of_the_container(cloud: Cloud) -> None:
    lease = lent(cloud)
    came(cloud, "a")
    after = Cloud(state=cloud.node.checkpoint())
    came(after, "b")
    assert names(after.hold("driver", lease, state="{}").unheard) == ["a", "b"]


def test_oldest_unheard_message_is_dropped_beyond_the_limit(cloud: Cloud) -> None:
    lease = lent(cloud)
    came(cloud, *map(str, range(MOST + 1)), "50")
    unheard = names(cloud.hold("driver", lease, state="{}").unheard)
    assert (len(unheard), unheard[0], unheard[-1]) == (MOST, "1", "50")


# -- what a robot that drives by itself knows --------------------------------------------------------------------------


def state_of_stops(cloud: Cloud, *texts: str) -> list[str]:
    """Publish states of stops for the node that is away; return their fingerprints."""
    states = [StopState(stopped=bool(text), text=text) for text in texts]
    for state in states:
        cloud.hands.came["driver"]("stop/state", state)
    return [fingerprint("stop/state", state) for state in states]


def test_a_message_is_lacked_until_the_robot_has_confirmed_the_last_one(cloud: Cloud) -> None:
    lease = lent(cloud)
    stopped, free = state_of_stops(cloud, "stopped by 'ann'", "")
    came(cloud, "a")
    assert cloud.node.lacks("driver", "stop/state")
    assert len(cloud.hold("driver", lease, state="{}", heard=[stopped]).unheard) == 2, "the earlier state is outdated"
    assert cloud.node.lacks("driver", "stop/state")
    cloud.hold("driver", lease, state="{}", heard=[free])
    assert not cloud.node.lacks("driver", "stop/state")


def test_a_robot_that_is_lost_with_its_node_lacks_all_until_it_is_heard_of(cloud: Cloud) -> None:
    lease = lent(cloud)
    assert not cloud.node.lacks("driver", "stop/state")
    cloud.wait(4.0)
    assert cloud.node.lacks("driver", "stop/state"), "it may drive by itself"
    after = Cloud(state=cloud.node.checkpoint())
    assert after.node.lacks("driver", "stop/state")
    after.hold("driver", lease, state="{}")
    assert not after.node.lacks("driver", "stop/state"), "it was told that it holds no lease"
    cloud.ask("tell_robot", STRONG)
    assert not cloud.node.lacks("driver", "stop/state"), "its latch holds it on the new connection"


def rows(*entries: tuple[int, bytes]) -> list[LogEntry]:
    return [LogEntry(*entry) for entry in entries]


def test_the_log_of_a_node_moves_with_it_and_follows_its_changes(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("locator", "robot")
    cloud.hands.logs["locator"] = LogChange(rows((3, b"a"), (4, b"b")), [0, 1])
    taken = cloud.hold("locator")
    assert taken.log == [LogPart(3, b"a"), LogPart(4, b"b")]
    assert cloud.hold("locator", taken.lease, log=[LogPart(5, b"c")], obsolete=[3]).lease == taken.lease
    assert cloud.hold("locator").log == [LogPart(4, b"b"), LogPart(5, b"c")], "a robot that lost its state"
    assert cloud.node.logs.take_changes() == {"locator": LogChange(rows((4, b"b"), (5, b"c")), [0, 1, 3])}
    cloud.ask("give_node", GiveNodeRequest("locator", 2, "{}", log=[LogPart(6, b"d")], obsolete=[4]))
    assert cloud.hands.restored["locator"] == rows((5, b"c"), (6, b"d"))
    assert cloud.node.logs.take_changes() == {"locator": LogChange(rows((6, b"d")), [4])}
    assert cloud.node.logs.nodes == ()


def test_a_node_that_the_robot_ran_on_another_map_is_here_until_the_robot_takes_it(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("driver", "robot")
    lease = cloud.hold("driver").lease
    other = Cloud()
    other.node.carry_over(cloud.node.checkpoint())
    assert "driver" in other.hands.here
    assert other.hold("driver", lease, state="{}").lease == 0, "its state is of the other map"
    assert other.hold("driver").lease > lease


def test_a_lost_robot_leaves_the_log_that_it_reported(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("locator", "robot")
    cloud.hands.logs["locator"] = LogChange(rows((0, b"a")), [])
    cloud.hold("locator", cloud.hold("locator").lease, log=[LogPart(1, b"b")])
    cloud.wait(60.0)
    assert cloud.homes()["locator"] == "cloud"
    assert cloud.hands.restored["locator"] == rows((0, b"a"), (1, b"b"))


def test_the_log_of_a_leased_node_is_loaded_in_a_new_process(cloud: Cloud) -> None:
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("locator", "robot")
    cloud.hands.logs["locator"] = LogChange(rows((0, b"a")), [])
    lease = cloud.hold("locator").lease
    another = Cloud(state=cloud.node.checkpoint())
    assert another.node.logs.nodes == ("locator",)
    another.node.logs.load("locator", rows((0, b"a")))
    another.hold("locator", lease, log=[LogPart(1, b"b")])
    assert another.node.logs.of("locator") == rows((0, b"a"), (1, b"b"))


def test_a_node_with_too_large_a_log_stays(cloud: Cloud, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(monitor, "MOST_BYTES", 1 << 20)
    cloud.ask("tell_robot", STRONG)
    cloud.run_node("locator", "robot")
    change = cloud.hands.logs["locator"] = LogChange(rows((0, bytes(2 << 20))), [])
    with pytest.raises(Unavailable, match="locator stays in the cloud: its log of 2 MiB is too large to be moved"):
        cloud.hold("locator")
    assert cloud.hands.done == []
    home = next(home for home in cloud.ask("list_nodes", Empty()).nodes if home.node == "locator")  # type: ignore[union-attr]
    assert (home.wanted, home.reasons) == ("cloud", ["its log of 2 MiB is too large to be moved, at most 1 MiB are"])
    assert cloud.node.logs.take_changes() == {"locator": change}, "the node has written its log anew"
