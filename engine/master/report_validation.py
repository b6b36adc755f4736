"""What machines say of themselves, and what of it can be believed.

Nobody can tell from afar how many cores a machine has. But what no machine has is refused, and what a machine says of
others: then it is cut off, as one whose agent is broken.
"""

import math

from engine.master.machine import Machine
from engine.protocols import control_link
from engine.specs.machine_settings import check_labels
from ppaas import __version__
from ppaas.errors import InvalidParameter, NotPermitted
from storage.names import check_name

MOST_CORES = 4096
LEAST_MEMORY = 1 << 24
MOST_MEMORY = 1 << 46
MOST_NETWORK = 1e12


def machine_of(register: control_link.Register) -> Machine:
    """Return the machine that registers.

    Raises
    ------
    InvalidInput
        Its name is none, or a size or a label.
    NotPermitted
        It runs another release of this program.
    """
    _check_release(register)
    check_name("machine", register.machine)
    check_labels(register.labels)
    _check(register.machine, "cores", register.cores, 1, MOST_CORES)
    _check(register.machine, "bytes of memory", register.memory, LEAST_MEMORY, MOST_MEMORY)
    _check(register.machine, "bytes a second of its network", register.network, 0.0, MOST_NETWORK)
    return Machine(
        register.machine,
        register.cores,
        register.memory,
        register.pid,
        labels=register.labels,
        network=register.network,
    )


def _check_release(register: control_link.Register) -> None:
    """Let nobody in who may understand orders otherwise than they are meant."""
    if register.release != __version__:
        raise NotPermitted(
            f"machine {register.machine[:64]!r} runs release {register.release[:64] or '(untold)'} and this cloud "
            f"{__version__}: what it carries ends, and is started anew from checkpoints"
        )


def note_load(machine: Machine, heartbeat: control_link.Heartbeat) -> None:
    """Note what a machine says of its load; raises as ``check_heartbeat`` does."""
    check_heartbeat(machine, heartbeat)
    machine.cpu, machine.memory_used = heartbeat.cpu, heartbeat.memory_used
    machine.network_used, machine.neighbours = heartbeat.network_used, heartbeat.round_trips
    machine.average_round_trips()
    machine.loads = {load.container: load for load in heartbeat.containers}


def check_heartbeat(machine: Machine, heartbeat: control_link.Heartbeat) -> None:
    """Make sure that a machine uses what a machine of its size can use.

    Raises
    ------
    InvalidParameter
        It does not.
    """
    _check(machine.id, "cores in use", heartbeat.cpu, 0.0, MOST_CORES)
    _check(machine.id, "bytes in use", heartbeat.memory_used, 0, machine.memory)
    _check(machine.id, "bytes a second", heartbeat.network_used, 0.0, MOST_NETWORK)
    for round_trip in heartbeat.round_trips.values():
        _check(machine.id, "seconds of a round trip", round_trip, 0.0, math.inf)
    for load in heartbeat.containers:
        _check(machine.id, "cores of a container", load.cpu, 0.0, MOST_CORES)
        _check(machine.id, "bytes of a container", load.pss, 0, machine.memory)


def _check(machine: str, what: str, value: float, least: float, most: float) -> None:
    if not (math.isfinite(value) and least <= value <= most):
        raise InvalidParameter(f"machine {machine!r} says {value} {what}: there are from {least:g} to {most:g}")
