"""Endpoint processes of this host: their ports, which are reserved for them, their settings, and the record of them.

By the record, a cloud process finds the endpoints of a killed one.
"""

import argparse
import contextlib
import logging
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from endpoints.cloud_processes.config import EndpointConfig, FrontConfig, front_config
from endpoints.listeners import listen, url_of
from engine.bootstrap import Engine
from engine.leadership.leadership import holder_of
from engine.local.process_keeper import left_processes
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)


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


@dataclass(frozen=True, slots=True)
class Ports:
    """Sockets that reserve the ports of REST and robots, of Rapyuta's robots, and of Foxglove's viewers."""

    web: Sequence[socket.socket]
    rapyuta: Sequence[socket.socket]
    foxglove: Sequence[socket.socket]

    @classmethod
    def reserve(cls, arguments: argparse.Namespace, stack: contextlib.ExitStack | contextlib.AsyncExitStack) -> "Ports":
        """Reserve the ports that the command line names, until ``stack`` is closed.

        Endpoints of a killed cloud process, which this one adopts, may listen there.

        Raises
        ------
        Unavailable
            A port is in use.
        """
        left = left_endpoints(arguments.data / ENDPOINTS_HERE)

        def reserved(port: int | None, before: int | None) -> list[socket.socket]:
            if port is None:
                return []
            port = port or before or 0
            found = _reserved(arguments.host, port, in_use=port != 0 and port == before)
            for each in found:
                stack.enter_context(each)
            return found

        port, rapyuta, foxglove = _ports(left[0].front) if left else (None, None, None)
        return cls(
            reserved(arguments.port, port),
            reserved(arguments.rapyuta, rapyuta),
            reserved(arguments.foxglove, foxglove),
        )

    def log(self, *, tls: bool) -> None:
        """Log the addresses other than the one of REST and robots."""
        if self.rapyuta:
            logger.info("serving robots of Rapyuta at %s", url_of(self.rapyuta[0], "https" if tls else "http"))
        if self.foxglove:
            logger.info("serving viewers of Foxglove at %s", url_of(self.foxglove[0], "wss" if tls else "ws"))


def _reserved(host: str, port: int, *, in_use: bool) -> list[socket.socket]:
    """Return sockets that hold a port at which only processes of this cloud listen."""
    if not in_use:
        for listener in listen(host, port):
            port = listener.getsockname()[1]
            listener.close()
    return listen(host, port, shared=True, accept=False)


def _ports(config: FrontConfig) -> tuple[int, int | None, int | None]:
    return config.port, config.rapyuta, config.foxglove


def _port_of(sockets: Sequence[socket.socket]) -> int | None:
    return int(sockets[0].getsockname()[1]) if sockets else None


def endpoint_configs(arguments: argparse.Namespace, engine: Engine, ports: Ports) -> list[EndpointConfig]:
    """Return the settings of the endpoint processes of this host."""
    first = _config(arguments, engine, ports)
    names = [f"{first.machine}-{number}" for number in range(1, arguments.endpoints + 1)]
    return [msgspec.structs.replace(first, name=name) for name in names]


def _config(arguments: argparse.Namespace, engine: Engine, ports: Ports) -> EndpointConfig:
    cloud = engine.config
    return EndpointConfig(
        name="",
        machine=cloud.machine,
        run_dir=str(engine.run_dir),
        secret=engine.secret,
        store=cloud.store,
        map_store=cloud.map_store,
        outbox=cloud.outbox,
        reserve=cloud.reserve,
        recordings=cloud.recordings,
        machines=cloud.machines if cloud.listen_machines is not None else None,
        listen_machines=cloud.listen_machines,
        data=str(arguments.data.resolve()),
        keep_versions=cloud.keep_versions,
        quota=cloud.quota,
        linger=arguments.linger,
        holder=holder_of(arguments.data),
        orphaned=arguments.adopt_within,
        allowed=tuple(arguments.allow),
        front=_front(arguments, ports),
    )


def _front(arguments: argparse.Namespace, ports: Ports) -> FrontConfig:
    return front_config(
        arguments,
        url=url_of(ports.web[0], "https" if arguments.tls_cert else "http"),
        port=ports.web[0].getsockname()[1],
        rapyuta=_port_of(ports.rapyuta),
        foxglove=_port_of(ports.foxglove),
    )
