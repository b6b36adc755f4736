"""Pure parts of ``ppaas bench wire``: its frame, the node that answers it, and the figures."""

from typing import Any

import psutil
import pytest

from benchmarks.commands.cloud import WireBench
from benchmarks.wire import half_open, latency, load, stop, suite, two_endpoints
from benchmarks.wire.echo_runtime import NO_PROCESS, VELOCITY, Echo
from benchmarks.wire.load import FrameCosts, frame_costs
from benchmarks.wire.site import BEAMS, scan_frame
from ppaas.clock import monotonic
from ppaas.messages import decode
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.graph import Graph
from ppaas.wire.operations import Publish
from ppaas.wire.rosbridge import RosbridgeSession


class Sockets:
    """Notes what is sent on a socket, and takes CPU time for it."""

    def __init__(self) -> None:
        self.sent: list[str] = []

    async def send(self, frame: str) -> None:
        self.sent.append(frame)


def sent_scan() -> LaserScan:
    """Return the scan in the frame, as a container reads it."""
    published = RosbridgeSession().receive(scan_frame())
    assert isinstance(published, Publish) and published.topic == "scan"
    return decode(LaserScan, bytes(published.msg))


def test_the_frame_is_a_scan_of_four_kilobytes() -> None:
    scan = sent_scan()
    assert len(scan.ranges) == len(scan.intensities) == BEAMS
    assert 3_500 <= len(scan_frame()) <= 4_500


def test_the_container_of_the_bench_answers_each_scan_with_a_velocity() -> None:
    graph, heard = Graph(), list[Any]()
    graph.add(Echo)
    graph.tap("cmd_vel", lambda _, message: heard.append(message))
    for _ in range(3):
        graph.inject("scan", sent_scan())
    assert heard == [VELOCITY] * 3


def test_no_process_has_the_id_of_a_task() -> None:
    assert not psutil.pid_exists(NO_PROCESS)


def test_the_command_names_the_parts_of_the_bench() -> None:
    assert (*suite.PARTS, two_endpoints.PART, stop.PART) == WireBench.PARTS


def test_added_latency_is_the_difference_of_medians() -> None:
    figures = latency.figures([0.001, 0.002, 0.003], [0.001, 0.001, 0.004], 4000, 100)
    added = {figure.name: figure for figure in figures}["added"]
    assert (added.value, added.kept) == (1.0, False)
    assert [figure.yardstick for figure in figures] == [False, False, True, True, False, False]
    assert latency.figures([0.0014], [0.001], 4000, 100)[4].kept


def test_the_ratio_of_cpu_times_is_that_of_loads_in_turn() -> None:
    ratio = load.cpu_figures([(300.0, 100.0), (200.0, 100.0), (400.0, 200.0)], 1)[-1]
    assert (ratio.value, ratio.least, ratio.most, ratio.kept) == (2.0, 2.0, 3.0, True)


def test_idle_memory_has_its_bar() -> None:
    assert [figure.kept for figure in load.memory_figures(61.0, 20.0, 1000, 1)] == [False, None]
    assert load.memory_figures(60.0, 20.0, 1000, 2)[0].kept


def test_a_request_without_an_answer_among_half_open_connections_misses_the_limit() -> None:
    *times, failed, held = half_open.figures([0.001] * 3, [0.002, 0.002, 0.009], 1, 10_000, 5_100)
    assert [(figure.value, figure.yardstick) for figure in times] == [
        (2.0, False),
        (9.0, False),
        (1.0, True),
        (1.0, True),
    ]
    assert (failed.value, failed.kept, held.value) == (1, False, 5_100)
    assert half_open.figures([0.1], [0.1], 0, 1, 1)[-2].kept


async def test_costs_of_a_load_leave_out_what_is_taken_without_it() -> None:
    sockets, began, robots = Sockets(), monotonic(), 3

    def cpu() -> list[float]:
        """Return the CPU time of a process that takes a core without load, and of one that takes 1 s for a frame."""
        return [monotonic() - began, float(len(sockets.sent))]

    costs = await frame_costs(cpu, [sockets] * robots, "scan", 0.1)  # type: ignore[list-item]
    assert costs.frames == len(sockets.sent) == 2 * robots
    assert costs.seconds[0] < 0.05 and costs.seconds[1] == costs.frames
    assert costs.each == pytest.approx(1.0, abs=0.05)


def test_two_endpoints_carry_what_the_busier_one_has_time_for() -> None:
    alone, even, uneven = FrameCosts([2.0], 1000), FrameCosts([1.0, 1.0], 1000), FrameCosts([1.5, 0.5], 1000)
    assert two_endpoints.carried(alone) == 500
    gains = [two_endpoints.figures((alone, 0.0), (both, 0.1))[-1] for both in (even, uneven)]
    assert [(gain.value, gain.kept) for gain in gains] == [(2.0, True), (1.33, False)]
    assert "+50% of an even share" in gains[1].note and "takes +0% CPU time" in gains[1].note


def test_stops_have_a_limit_and_stand_beside_an_echo() -> None:
    median, p99, *plain = stop.figures([0.008, 0.009, 0.080], [0.001], 100)
    assert (median.value, median.limit, p99.value, p99.limit) == (9.0, stop.LIMIT, 80.0, None)
    assert all(figure.yardstick and figure.limit is None for figure in plain)
