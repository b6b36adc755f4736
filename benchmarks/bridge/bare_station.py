"""Program: a ground station of pymavlink alone, which reads what a rover sends and writes ten setpoints a second."""

import sys
from time import monotonic
from typing import Any

from pymavlink import mavutil

from robots.bridges.mavlink.dialect import mavlink
from robots.bridges.mavlink.rover import RATES

PERIOD = 0.1
"""Time between two setpoints [s]."""


def main(address: str) -> None:
    """Be the station of the first vehicle at an address until killed."""
    link: Any = mavutil.mavlink_connection(address, source_system=255)
    link.wait_heartbeat()
    target = link.target_system, link.target_component
    for number, rate in RATES.items():
        link.mav.command_long_send(*target, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, number, 1e6 / rate, 0, 0, 0, 0, 0)
    due = monotonic()
    while True:
        link.recv_match(blocking=True, timeout=0.02)
        if monotonic() >= due:
            due += PERIOD
            numbers = 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1
            link.mav.set_position_target_local_ned_send(
                0, *target, mavlink.MAV_FRAME_BODY_NED, 0x5E7, 0.0, 0.0, 0.0, *numbers
            )


if __name__ == "__main__":
    main(sys.argv[1])
