"""Endpoint processes of a joined machine, as its agent keeps them."""

import msgspec

from endpoints.processes import serving
from endpoints.processes.config import FrontConfig, JoinedEndpointConfig
from engine.remote.endpoint_processes import EndpointProcesses


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
    """
    config = JoinedEndpointConfig(name="", run_dir="", folder="", listen=listen, front=front)
    return EndpointProcesses(serving.__name__, count, msgspec.to_builtins(config))
