"""Endpoint processes of a joined machine, as its agent keeps them."""

import msgspec

from endpoints.processes import serving
from endpoints.processes.config import FrontConfig, JoinedEndpointConfig
from engine.remote.endpoint_processes import EndpointProcesses
from ppaas.errors import InvalidInput


def joined_processes(count: int, front: FrontConfig, listen: str = "") -> EndpointProcesses:
    """Return the endpoint processes of a joined machine.

    Parameters
    ----------
    count : int
        Number of processes.
    front : FrontConfig
        Settings with which they serve clients.
    listen : str
        Host or address at which containers of other hosts reach them.

    Raises
    ------
    InvalidInput
        They would not have one port.
    """
    if front.port == 0:
        raise InvalidInput("endpoints of other hosts need a --port other than 0: all of a host listen there")
    config = JoinedEndpointConfig(name="", run_dir="", folder="", listen=listen, front=front)
    return EndpointProcesses(serving.__name__, count, msgspec.to_builtins(config))
