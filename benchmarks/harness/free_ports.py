"""Free ports of loopback for servers that need a fixed port."""

import contextlib
import secrets
import socket

LOWEST, END = 20_000, 32_768
"""Range of ports. It ends below the ephemeral ports (``net.ipv4.ip_local_port_range``), which the kernel could give to
a connection before the server listens, and begins above the ports of Ray's workers."""


def free_ports(count: int, address: str = "127.0.0.1") -> list[int]:
    """Return ``count`` consecutive ports of an address that are free now."""
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
