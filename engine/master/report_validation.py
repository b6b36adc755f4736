"""Validation of the reports of machines.

The master cannot verify how many cores a machine has. It refuses values that no machine can have, and disconnects the
machine that reported them: its agent is broken.
"""

import math

from engine.master.machine import Machine
from engine.protocols import control_link
from engine.protocols.versions import agree
from engine.specs.machine_settings import check_labels
from engine.specs.work_counts import check_counts
from ppaas.errors import InvalidParameter
from storage.names import check_name

MOST_CORES = 4096
LEAST_MEMORY = 1 << 24
MOST_MEMORY = 1 << 46
"""Bounds of a plausible memory [bytes]: 16 MiB, 64 TiB."""
MOST_NETWORK = 1e12
"""Upper bound of a plausible network rate [bytes/s]."""


def check_registration(register: control_link.Register) -> int:
    """Check that the values of a registration are possible; return the protocol version of the link.

    Raises
    ------
    InvalidInput
        Its name, a label or a size is not valid.
    Conflict
        It speaks no protocol of the cloud.
    """
    protocol = agree(f"machine {register.machine[:64]!r}", register.release, register.protocols)
    check_name("machine", register.machine)
    check_labels(register.labels)
    _check(register.machine, "cores", register.cores, 1, MOST_CORES)
    _check(register.machine, "bytes of memory", register.memory, LEAST_MEMORY, MOST_MEMORY)
    _check(register.machine, "bytes a second of its network", register.network, 0.0, MOST_NETWORK)
    return protocol


def check_heartbeat(machine: Machine, heartbeat: control_link.Heartbeat) -> None:
    """Check that the load of a machine is possible for its size.

    Raises
    ------
    InvalidParameter
        A value is out of range.
    """
    _check(machine.id, "cores in use", heartbeat.cpu, 0.0, MOST_CORES)
    _check(machine.id, "bytes in use", heartbeat.memory_used, 0, machine.memory)
    _check(machine.id, "bytes a second", heartbeat.network_used, 0.0, MOST_NETWORK)
    check_counts(heartbeat.work)
    for round_trip in heartbeat.round_trips.values():
        _check(machine.id, "seconds of a round trip", round_trip, 0.0, math.inf)
    for load in heartbeat.containers:
        _check(machine.id, "cores of a container", load.cpu, 0.0, MOST_CORES)
        _check(machine.id, "bytes of a container", load.pss, 0, machine.memory)


def _check(machine: str, what: str, value: float, least: float, most: float) -> None:
    if not (math.isfinite(value) and least <= value <= most):
        raise InvalidParameter(f"machine {machine!r} reports {value} {what}, not within {least:g} to {most:g}")
