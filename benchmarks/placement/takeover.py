"""Take-over: a new master adopts the containers of all machines, from the frames with which these register."""

import struct
from collections.abc import Iterator
from pathlib import Path

import msgspec

from benchmarks.placement.simulated_cloud import CORES, MEMORY, SimulatedCloud, new_master
from benchmarks.placement.timed_master import TimedMaster
from engine.master.events import MachineJoined, RobotTimed
from engine.master.master import LOG_SIZE
from engine.protocols import control_link
from ppaas import __version__

SECRET = "0" * 32
"""Secret of each machine and container: as long as those of a cloud."""

LENGTH = struct.Struct("!I")
"""Length before each registration in the file [bytes]."""


def write_registrations(cloud: SimulatedCloud, file: Path) -> None:
    """Write to a file how each machine registers with the next master: with the clones that it runs."""
    with file.open("wb") as out:
        for machine in cloud.timed.master.machines.values():
            carries = tuple(
                control_link.RunningContainer(spec, spec.cores, SECRET, 1) for spec in machine.containers.values()
            )
            register = control_link.Register(machine.id, SECRET, 1, CORES, MEMORY, carries=carries, release=__version__)
            body = msgspec.msgpack.encode(register)
            out.write(LENGTH.pack(len(body)) + body)


def _registrations(file: Path) -> Iterator[bytes]:
    with file.open("rb") as frames:
        while head := frames.read(LENGTH.size):
            yield frames.read(LENGTH.unpack(head)[0])


def adopt(file: Path) -> Iterator[TimedMaster]:
    """Let machines register with a new master; yield it after each of them, and once more when its log is turned over.

    Its log then holds events of robots, as that of a master does that has led for a moment.
    """
    timed, decoder = new_master(), msgspec.msgpack.Decoder(control_link.Register)
    for frame in _registrations(file):
        register = timed.timed("registration, decoding", lambda body=frame: decoder.decode(body))  # type: ignore[misc]
        joined = MachineJoined(
            register.machine, register.cores, register.memory, register.pid, carries=register.carries
        )
        timed.handle("adoption", joined)
        yield timed
    for _ in range(LOG_SIZE):
        timed.master.handle(RobotTimed("robot:none/none", 0.0))
    yield timed
