"""Records of the endpoint processes of a host, by which a cloud process finds those of a killed one."""

from pathlib import Path

import msgspec

from endpoints.processes.config import EndpointConfig
from engine.processes.instances import is_dead

ENDPOINTS_HERE = "endpoints-here.json"
"""File in the data folder that a killed process leaves to the next."""


class EndpointRecord(msgspec.Struct, frozen=True):
    """Endpoint process that was started: its instance name, and its settings."""

    process: str
    config: EndpointConfig


def left_endpoints(file: Path) -> list[EndpointRecord]:
    """Return the endpoints of a killed cloud process that still run."""
    try:
        records = msgspec.json.decode(file.read_bytes(), type=list[EndpointRecord])
    except (OSError, msgspec.DecodeError):
        return []
    return [record for record in records if not is_dead(record.process)]
