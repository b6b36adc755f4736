"""Records of the endpoint processes of a host, by which a cloud process finds the endpoints of a killed one."""

from pathlib import Path

import msgspec

from endpoints.processes.config import EndpointConfig
from engine.local.process_keeper import left_processes
from ppaas.decoding import from_json

ENDPOINTS_HERE = "endpoints-here.json"
"""File in the data folder that a killed process leaves to the next."""


def left_endpoints(file: Path) -> list[EndpointConfig]:
    """Return the settings of the endpoints of a killed cloud process that still run."""
    found = []
    for left in left_processes(file):
        try:
            found.append(from_json(left.settings, EndpointConfig))
        except msgspec.DecodeError:  # of another release
            continue
    return found
