"""Free ports for servers."""

import socket

from benchmarks.harness import free_ports as module
from benchmarks.harness.free_ports import END, LOWEST, free_ports


def test_consecutive_free_ports_are_returned() -> None:
    ports = free_ports(3)
    assert ports == list(range(ports[0], ports[0] + 3))
    assert ports[0] >= LOWEST and ports[-1] < END
    for port in ports:
        with socket.create_server(("127.0.0.1", port)):
            pass


def test_a_range_with_a_port_in_use_is_skipped(monkeypatch) -> None:
    first = free_ports(4)[0]
    places = iter([first - LOWEST, first - LOWEST + 2])
    monkeypatch.setattr(module.secrets, "randbelow", lambda _: next(places))
    with socket.create_server(("127.0.0.1", first + 1)):
        assert free_ports(2) == [first + 2, first + 3]
