"""Connection of a simulated rover, by pymavlink's own: it drives in real time."""

from typing import Any

from pymavlink import mavutil

from ppaas.clock import monotonic
from robots.bridges.mavlink.dialect import mavlink
from robots.sim.mavlink.rover import SimulatedRover

STEP = 0.02
"""Time between two steps [s]."""


class ServedRover:
    """Rover with a connection.

    Parameters
    ----------
    rover : SimulatedRover
    station : str
        Where its station is, as pymavlink writes it: ``udpout:127.0.0.1:14550``.
    key : bytes, optional
        Key of signatures.
    """

    def __init__(self, rover: SimulatedRover, station: str, key: bytes | None = None) -> None:
        self.rover = rover
        self._link: Any = mavutil.mavlink_connection(
            station, source_system=rover.system, source_component=mavlink.MAV_COMP_ID_AUTOPILOT1
        )
        if key is not None:
            self._link.setup_signing(key)
        self._before = monotonic()

    def pump(self) -> None:
        """Take the messages that have come, drive for the time that has passed, and send what is due."""
        while (message := self._link.recv_msg()) is not None:
            if message.get_type() != "BAD_DATA":
                self.rover.take(message)
        now = monotonic()
        self.rover.step(now - self._before)
        self._before = now
        for message in self.rover.take_sent():
            self._link.mav.send(message)

    def close(self) -> None:
        """Close the connection."""
        self._link.close()
