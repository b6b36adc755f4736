"""Node ``laser_proc``: one of several echoes."""

import pytest

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import LaserEcho, LaserScan, MultiEchoLaserScan
from ppaas.nodes.graph import Graph
from ppaas.nodes.laser_proc import LaserProcNode, LaserProcParameters
from ppaas.parameters import read_parameters

HEADER = Header(Time(7, 5), "laser")


def scan_of(echo: str, ranges: list[list[float | None]], intensities: list[list[float | None]]) -> LaserScan:
    graph = Graph()
    heard: list[LaserScan] = []
    node = graph.add(lambda context: LaserProcNode(context, LaserProcParameters(echo)))  # type: ignore[arg-type]
    node.context.publish = lambda _topic, message: heard.append(message)  # type: ignore[method-assign]
    beams, bright = ([LaserEcho(each) for each in lists] for lists in (ranges, intensities))
    node.on_message("echoes", MultiEchoLaserScan(HEADER, -1.0, 1.0, 1.0, 0.1, 9.0, beams, 0.1, 0.2, bright))
    (scan,) = heard
    return scan


@pytest.mark.parametrize(
    ("echo", "ranges", "intensities"),
    [
        ("first", [1.0, None, 4.0], [5.0, None, 1.0]),
        ("last", [2.0, None, 4.0], [7.0, None, 1.0]),
        ("most_intense", [1.5, None, 4.0], [9.0, None, 1.0]),
    ],
)
def test_the_wanted_echo_of_each_beam_is_taken(echo: str, ranges: list[float], intensities: list[float]) -> None:
    scan = scan_of(echo, [[1.0, 1.5, 2.0], [], [4.0]], [[5.0, 9.0, 7.0], [], [1.0]])
    assert (scan.ranges, scan.intensities) == (ranges, intensities)
    assert (scan.header, scan.angle_min, scan.range_max, scan.time_increment) == (HEADER, -1.0, 9.0, 0.1)


def test_intensities_are_needed_for_the_most_intense_echo_alone() -> None:
    assert scan_of("last", [[1.0, 2.0]], []).ranges == [2.0]
    with pytest.raises(InvalidInput, match="beam 0 has 2 echoes and 0 intensities"):
        scan_of("most_intense", [[1.0, 2.0]], [])


def test_an_unknown_echo_is_refused() -> None:
    with pytest.raises(InvalidParameter, match="echo"):
        read_parameters(LaserProcParameters, "laser_proc", {"echo": "strongest"})
