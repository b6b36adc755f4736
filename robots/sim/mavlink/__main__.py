"""Program ``python -m robots.sim.mavlink``: a simulated rover, which a station or ``ppaas bridge mavlink`` drives.

Lines on its standard input are what a person or bad luck does: ``mode MANUAL``, ``arm``, ``disarm``, ``fix 1``,
``refuse GPS is bad``, ``mute``, ``speak``, ``reboot``.
"""

import argparse
import math
import sys
import threading
from pathlib import Path
from queue import SimpleQueue
from time import sleep

from ppaas.errors import InvalidInput
from robots.bridges.mavlink.station import key_of
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import SimulatedRover
from robots.sim.mavlink.serving import STEP, ServedRover


def main(words: list[str] | None = None) -> None:
    """Run until interrupted."""
    arguments = arguments_of(words)
    start = RoverBody(
        arguments.latitude, arguments.longitude, math.radians(arguments.heading), top_speed=arguments.speed
    )
    rover = SimulatedRover(arguments.make, start, arguments.system)
    rover.armed = arguments.armed
    try:
        key = None if arguments.passphrase_file is None else key_of(arguments.passphrase_file)
        _run(ServedRover(rover, arguments.station, key))
    except (InvalidInput, OSError) as error:
        raise SystemExit(f"robots.sim.mavlink: {error}") from error
    except KeyboardInterrupt:
        return


def _run(served: ServedRover) -> None:
    orders = SimpleQueue[str]()
    threading.Thread(target=_listen, args=(orders,), daemon=True).start()
    while True:
        sleep(STEP)
        while not orders.empty():
            _obey(served, orders.get())
        served.pump()


def _listen(orders: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        orders.put(line)


def _obey(served: ServedRover, order: str) -> None:
    try:
        served.rover.order(order)
    except ValueError as error:
        sys.stderr.write(f"{error}\n")


def arguments_of(words: list[str] | None) -> argparse.Namespace:
    """Return the arguments of a command line, by default the one of this process."""
    parser = argparse.ArgumentParser(prog="python -m robots.sim.mavlink", description=__doc__)
    parser.add_argument("--make", choices=("ardupilot", "px4"), default="ardupilot")
    parser.add_argument("--station", default="udpout:127.0.0.1:14550", help="where the station is (%(default)s)")
    parser.add_argument("--system", type=int, default=1, help="number of the vehicle (%(default)s)")
    parser.add_argument("--latitude", type=float, required=True, help="where it starts [°]")
    parser.add_argument("--longitude", type=float, required=True, help="likewise")
    parser.add_argument("--heading", type=float, default=0.0, help="clockwise from north [°]")
    parser.add_argument("--speed", type=float, default=1.0, help="its top speed [m/s]")
    parser.add_argument("--armed", action="store_true", help="whether it is armed from the beginning")
    parser.add_argument("--passphrase-file", type=Path, help="sign with the key of a file: a passphrase, or digits")
    arguments = parser.parse_args(words)
    if not 1 <= arguments.system <= 255:
        parser.error(f"--system is a number from 1 to 255, not {arguments.system}")
    if not (abs(arguments.latitude) < 90.0 and abs(arguments.longitude) <= 180.0):
        parser.error("--latitude is between -90 and 90, and --longitude from -180 to 180")
    return arguments


if __name__ == "__main__":
    main()
