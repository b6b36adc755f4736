"""Ports of loopback for servers that must be told theirs before they start."""

import contextlib
import secrets
import socket

LOWEST, END = 20_000, 32_768
"""Below those that connections get by themselves (``net.ipv4.ip_local_port_range``): one of these may be taken again
before the server that is told of it listens. Above those that Ray's workers get."""


def free_ports(count: int, address: str = "127.0.0.1") -> list[int]:
    """Return so many ports of an address, one after the other, that nobody uses now."""
    while True:
        first = LOWEST + secrets.randbelow(END - LOWEST - count + 1)
        ports = list(range(first, first + count))
        with contextlib.ExitStack() as listening:
            try:
                for port in ports:
                    listening.enter_context(socket.create_server((address, port)))
            except OSError:
                continue
        return ports
