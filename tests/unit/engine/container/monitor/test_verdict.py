"""Verdicts on homes: weak robots are served by the cloud, urgent nodes run on the robot, verdicts are monotonic."""

import math
from dataclasses import replace
from typing import Any

import msgspec
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from engine.container.monitor.facts import MonitoredNode, NetworkLink, RobotComputer
from engine.container.monitor.measurements import KEPT, History, TopicRates
from engine.container.monitor.parameters import CRITERIA, NodeMonitorParameters
from engine.container.monitor.verdict import asked, judge
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.base import Demands
from ppaas.nodes.torso_detector.node import TorsoDetectorNode

PLAIN = NodeMonitorParameters()
PI = RobotComputer(4, 1.5, 1.0, ("driver",))
LAPTOP = RobotComputer(8, 3.0, 5.0, ("driver",))
GOOD, BAD = NetworkLink(0.005, 10e6), NetworkLink(0.3, 100e3)
DRIVER = MonitoredNode("driver", Demands(0.6), {"scan": 80e3})


def test_raspberry_pi_is_served_by_the_cloud_on_any_link() -> None:
    for link in (GOOD, BAD, None):
        verdict = judge(PI, link, DRIVER, PLAIN)
        assert verdict.home == "cloud"
        assert "the robot is weak: it has the power of 4.0 cores of a Raspberry Pi 4" in verdict.reasons[0]


def test_strong_robot_with_a_bad_link_runs_the_node() -> None:
    verdict = judge(LAPTOP, BAD, DRIVER, PLAIN)
    assert verdict.home == "robot"
    assert any("of a link with 100 KB/s" in reason or "link takes 300 ms" in reason for reason in verdict.reasons)


def test_node_with_high_data_rates_runs_on_the_robot() -> None:
    image = MonitoredNode("driver", Demands(0.6), {"image": 9e6})
    middling = RobotComputer(4, 3.0, 2.0, ("driver",))
    first = NodeMonitorParameters(priorities=("network_bandwidth", "computation_power"))
    assert judge(middling, GOOD, DRIVER, first).home == "cloud"
    verdict = judge(middling, GOOD, image, first)
    assert verdict.home == "robot"
    assert "its topics would use 9000 KB/s of a link with 10000 KB/s" in verdict.reasons[0]


def test_the_torso_detector_runs_where_the_images_are_although_amcl_runs_in_the_cloud() -> None:
    """On a robot a little faster than a Raspberry Pi 4; on the Pi itself if bandwidth is the first criterion."""
    better = RobotComputer(4, 1.8, 1.5, ("torso_detector", "amcl"))
    detector, amcl = (
        MonitoredNode(kind.name, kind.demands, kind.demands.rates) for kind in (TorsoDetectorNode, AmclNode)
    )
    verdict = judge(better, GOOD, detector, PLAIN)
    assert verdict.home == "robot"
    assert any("its topics would use 24576 KB/s" in reason for reason in verdict.reasons)
    assert judge(better, GOOD, amcl, PLAIN).home == "cloud"
    pi = RobotComputer(PI.cores, PI.clock, PI.benchmark, better.nodes)
    first = NodeMonitorParameters(priorities=("network_bandwidth", "computation_power"))
    assert (judge(pi, GOOD, detector, PLAIN).home, judge(pi, GOOD, detector, first).home) == ("cloud", "robot")


def test_time_critical_node_runs_on_a_capable_robot() -> None:
    middling = RobotComputer(4, 2.0, 2.2, ("driver",))
    assert judge(middling, GOOD, DRIVER, PLAIN).home == "cloud"
    assert judge(middling, GOOD, replace(DRIVER, demands=Demands(0.6, time_critical=True)), PLAIN).home == "robot"
    assert judge(middling, GOOD, DRIVER, NodeMonitorParameters(time_critical=("driver",))).home == "robot"


def test_first_priority_decides_if_it_is_certain() -> None:
    urgent = replace(DRIVER, demands=Demands(0.6, time_critical=True))
    others = ("computation_power", "network_bandwidth")
    assert judge(PI, GOOD, urgent, PLAIN).home == "cloud"
    assert judge(PI, GOOD, urgent, NodeMonitorParameters(priorities=("node_properties", *others))).home == "robot"
    assert judge(LAPTOP, GOOD, DRIVER, NodeMonitorParameters(priorities=("network_bandwidth",))).home == "cloud"


def test_measured_times_of_both_homes_are_compared() -> None:
    measured = NodeMonitorParameters(priorities=("node_properties",))
    slow_there = replace(DRIVER, cloud_seconds=0.002, robot_seconds=0.5)
    slow_here = replace(DRIVER, cloud_seconds=0.4, robot_seconds=0.01)
    middling = RobotComputer(2, 1.5, 0.9, ("driver",))
    assert judge(middling, GOOD, slow_there, measured).home == "cloud"
    assert judge(middling, GOOD, slow_here, measured).home == "robot"
    assert "500 ms on the robot, and 7 ms in the cloud" in judge(middling, GOOD, slow_there, measured).reasons[0]


@pytest.mark.parametrize(
    ("robot", "node", "reason"),
    [
        (None, DRIVER, "not reported a computer to run nodes on"),
        (LAPTOP, replace(DRIVER, demands=None), "stays in the cloud"),
        (LAPTOP, replace(DRIVER, name="other"), "cannot be run by this robot"),
        (LAPTOP, replace(DRIVER, failure="it was killed"), "could not be run on the robot: it was killed"),
        (
            LAPTOP,
            replace(DRIVER, taken=LAPTOP.power * 0.7 - 0.5),
            "takes 0.60 cores of a Raspberry Pi 4, and the robot has 0.50",
        ),
        (LAPTOP, replace(DRIVER, taken=99.0), "and the robot has 0.00 left"),
    ],
)
def test_cloud_runs_nodes_that_the_robot_cannot(robot: RobotComputer | None, node: MonitoredNode, reason: str) -> None:
    verdict = judge(robot, BAD, node, PLAIN)
    assert (verdict.home, verdict.score, len(verdict.reasons)) == ("cloud", 1.0, 1)
    assert reason in verdict.reasons[0]


def test_requested_home_is_granted() -> None:
    assert asked("robot") == ("robot", -1.0, ("a client requested this home",))
    assert asked("cloud")[:2] == ("cloud", 1.0)


@pytest.mark.parametrize("number", [0.0, -1.0, math.nan, math.inf])
def test_invalid_numbers_are_refused_by_name(number: float) -> None:
    with pytest.raises(InvalidInput, match="benchmark must be a positive number"):
        RobotComputer(4, 1.5, number)
    with pytest.raises(InvalidInput, match="rtt must be a positive number"):
        NetworkLink(number, 1.0)


@pytest.mark.parametrize(
    ("given_", "match"),
    [
        ({"priorities": ()}, "list one or more of computation_power"),
        ({"priorities": ("node_properties", "node_properties")}, "each once"),
        ({"weak_power": 20.0}, "less than strong_power"),
    ],
)
def test_invalid_priorities_are_refused(given_: dict[str, Any], match: str) -> None:
    with pytest.raises(InvalidParameter, match=match):
        NodeMonitorParameters(**given_)


# -- verdicts are monotonic in each input ------------------------------------------------------------------------------

positive = st.floats(0.01, 100.0)
seconds = st.floats(1e-4, 2.0)
robots = st.builds(RobotComputer, st.integers(1, 64), positive, positive, st.just(("driver",)))
links = st.builds(NetworkLink, seconds, st.floats(1e3, 1e9))
nodes = st.builds(
    MonitoredNode,
    st.just("driver"),
    st.builds(Demands, st.floats(0.0, 10.0), st.booleans()),
    st.dictionaries(st.sampled_from(["scan", "odom", "image"]), st.floats(0.0, 1e8)),
    cloud_seconds=seconds,
    robot_seconds=seconds,
    taken=st.floats(0.0, 10.0),
)
parameters = st.builds(NodeMonitorParameters, st.lists(st.sampled_from(CRITERIA), min_size=1, unique=True).map(tuple))


def score(robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters) -> float:
    verdict = judge(robot, link, node, by)
    assert -1.0 <= verdict.score <= 1.0
    assert (verdict.home == "cloud") == (verdict.score >= 0.0)
    return verdict.score


@given(robots, links, nodes, parameters, st.sampled_from(["cores", "clock", "benchmark"]), st.integers(1, 9))
def test_stronger_robot_never_loses_a_node(
    robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters, what: str, more: int
) -> None:
    stronger = msgspec.structs.replace(robot, **{what: getattr(robot, what) + more})
    assert score(stronger, link, node, by) <= score(robot, link, node, by) + 1e-9


@given(robots, links, nodes, parameters, st.floats(1.0, 50.0))
def test_better_link_never_moves_a_node_to_the_robot(
    robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters, times: float
) -> None:
    before = score(robot, link, node, by)
    assert score(robot, msgspec.structs.replace(link, bandwidth=link.bandwidth * times), node, by) >= before - 1e-9
    assert score(robot, msgspec.structs.replace(link, rtt=link.rtt / times), node, by) >= before - 1e-9


@given(robots, links, nodes, parameters, st.floats(0.0, 10.0))
def test_higher_demand_or_robot_time_favours_the_cloud(
    robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters, more: float
) -> None:
    before = score(robot, link, node, by)
    assert node.demands is not None and node.robot_seconds is not None
    heavier = replace(node, demands=replace(node.demands, compute=node.demands.compute + more))
    for pulled in (
        heavier,
        replace(node, robot_seconds=node.robot_seconds + more),
        replace(node, taken=node.taken + more),
    ):
        assert score(robot, link, pulled, by) >= before - 1e-9


@given(robots, links, nodes, parameters, st.floats(0.0, 1e8))
def test_higher_data_rate_or_cloud_time_favours_the_robot(
    robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters, more: float
) -> None:
    before = score(robot, link, node, by)
    assert node.cloud_seconds is not None
    thirsty = replace(node, rates={**node.rates, "more": more})
    for pulled in (thirsty, replace(node, cloud_seconds=node.cloud_seconds + more / 1e8)):
        assert score(robot, link, pulled, by) <= before + 1e-9


@given(robots, links, nodes, parameters)
def test_time_criticality_favours_the_robot(
    robot: RobotComputer, link: NetworkLink, node: MonitoredNode, by: NodeMonitorParameters
) -> None:
    assert node.demands is not None
    assume(not node.demands.time_critical)
    urgent = replace(node, demands=replace(node.demands, time_critical=True))
    assert score(robot, link, urgent, by) <= score(robot, link, node, by) + 1e-9


def test_delayed_or_invalid_values_do_not_move_the_median() -> None:
    history = History()
    assert history.median is None
    for value in (0.01, 0.012, 9.0, 0.0, -1.0):
        history.note(value)
    assert history.median == 0.012


def test_history_keeps_the_last_values_only() -> None:
    history = History()
    for n in range(1, 3 * KEPT):
        history.note(float(n))
    assert history.values == [float(n) for n in range(2 * KEPT, 3 * KEPT)]


def test_rate_is_measured_after_a_full_window() -> None:
    rates = TopicRates(window=2.0)
    rates.look(10.0)
    rates.note("scan", 300)
    rates.look(11.0)
    assert rates.of({"scan": 80.0, "image": 9.0}) == {"scan": 80.0, "image": 9.0}
    rates.note("scan", 500)
    rates.look(14.0)
    assert rates.of({"scan": 80.0, "image": 9.0}) == {"scan": 200.0}, "it sends no images"
    rates.look(17.0)
    assert rates.of({"scan": 80.0}) == {"scan": 200.0}, "a laser that rests is not forgotten"
