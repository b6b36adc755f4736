"""IPv6 of this computer, for tests that need it."""

import socket

import pytest


def has_ipv6() -> bool:
    """Return whether this computer has the loopback address of IPv6."""
    try:
        with socket.socket(socket.AF_INET6, socket.SOCK_STREAM) as probe:
            probe.bind(("::1", 0))
    except OSError:
        return False
    return True


needs_ipv6 = pytest.mark.skipif(not has_ipv6(), reason="this computer has no IPv6")
