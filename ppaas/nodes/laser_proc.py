"""Node ``laser_proc``: takes one echo of each beam of a laser that sends several, as ROS's node of that name does."""

from typing import ClassVar, Literal

from ppaas.errors import InvalidInput
from ppaas.messages.sensor_msgs import LaserEcho, LaserScan, MultiEchoLaserScan
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.message_checks import expect
from ppaas.nodes.topics import ECHOES, SCAN
from ppaas.parameters import Parameters

FIRST, LAST, MOST_INTENSE = "first", "last", "most_intense"


class LaserProcParameters(Parameters, frozen=True):
    """Parameters of `LaserProcNode`.

    Parameters
    ----------
    echo : {"first", "last", "most_intense"}
        Echo of each beam that is taken, by the names of ROS's topics: the nearest, the farthest, or the one with the
        highest intensity. A pane of glass is a first echo, and what is behind it a later one.
    """

    echo: Literal["first", "last", "most_intense"] = "first"


class LaserProcNode(Node):
    """Subscribes to ``echoes`` and publishes ``scan``, with its stamp and frame.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : LaserProcParameters
    """

    name: ClassVar[str] = "laser_proc"
    demands: ClassVar[Demands] = Demands(0.02)
    subscribes: ClassVar[tuple[Topic, ...]] = (ECHOES,)
    publishes: ClassVar[tuple[Topic, ...]] = (SCAN,)

    def __init__(self, context: Context, parameters: LaserProcParameters) -> None:
        super().__init__(context)
        self._echo = parameters.echo

    def on_message(self, topic: str, message: Payload) -> None:
        """Publish the scan of one echo.

        Raises
        ------
        InvalidInput
            The most intense echo is wanted, and a beam has another number of intensities than of echoes.
        """
        scan = expect(message, MultiEchoLaserScan)
        taken = [self._taken(scan, beam) for beam in range(len(scan.ranges))]
        ranges = [None if at is None else scan.ranges[beam].echoes[at] for beam, at in enumerate(taken)]
        known = len(scan.intensities) == len(scan.ranges)
        intensities = [_at(scan.intensities[beam], at) for beam, at in enumerate(taken)] if known else []
        self.context.publish(
            SCAN.name,
            LaserScan(
                scan.header, scan.angle_min, scan.angle_max, scan.angle_increment, scan.range_min, scan.range_max,
                ranges, scan.time_increment, scan.scan_time, intensities,
            ),
        )  # fmt: skip

    def _taken(self, scan: MultiEchoLaserScan, beam: int) -> int | None:
        """Return the place of the wanted echo of a beam; None if it has none."""
        count = len(scan.ranges[beam].echoes)
        if not count:
            return None
        if self._echo != MOST_INTENSE:
            return 0 if self._echo == FIRST else count - 1
        found = scan.intensities[beam].echoes if beam < len(scan.intensities) else []
        if len(found) != count:
            raise InvalidInput(
                f"beam {beam} has {count} echoes and {len(found)} intensities: laser_proc takes the most intense echo "
                f"by these; set its parameter echo to {FIRST!r} or {LAST!r}"
            )
        return max(range(count), key=lambda at: found[at] or 0.0)


def _at(echo: LaserEcho, at: int | None) -> float | None:
    return echo.echoes[at] if at is not None and at < len(echo.echoes) else None
