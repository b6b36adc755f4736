"""Endpoint processes of joined machines and nodes: the description that their agents get."""

from typing import Any

import msgspec


class EndpointProcesses(msgspec.Struct, frozen=True):
    """Endpoint processes of a machine.

    Parameters
    ----------
    module : str
        Module that runs one, with its settings as JSON on standard input.
    count : int
        Number of processes.
    settings : dict
        Settings of all, without the fields that only the machine knows: ``name``, ``folder`` and ``run_dir``.
    """

    module: str
    count: int
    settings: dict[str, Any]


def at_address(processes: EndpointProcesses, address: str) -> EndpointProcesses:
    """Return endpoint processes that listen at one address of their machine, for clients and for containers."""
    settings = processes.settings
    front = {**settings["front"], "host": address}
    return msgspec.structs.replace(processes, settings={**settings, "listen": address, "front": front})
