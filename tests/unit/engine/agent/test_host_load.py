"""Network load: choice of the interface, its capacity and its traffic."""

from types import SimpleNamespace
from typing import Any

import psutil
import pytest

from engine.agent.host_load import NetworkLoad, capacity_of, fastest
from ppaas.clock import ManualClock


def interface(speed: int = 1000, **fields: Any) -> Any:
    given = {"isup": True, "duplex": psutil.NIC_DUPLEX_FULL, "flags": "up,broadcast,running"}
    return SimpleNamespace(speed=speed, **(given | fields))


def test_fastest_external_interface_that_is_up_is_chosen() -> None:
    loopback = interface(65536, flags="up,loopback,running")
    found = {"lo": loopback, "wlan0": interface(300), "eth0": interface(1000), "eth1": interface(10000, isup=False)}
    assert fastest(found) == "eth0"
    assert fastest({"lo": loopback}) is None
    assert fastest({"tun0": interface(0)}) == "tun0"


def test_full_duplex_interface_has_twice_its_speed() -> None:
    assert capacity_of(interface(1000)) == 250e6
    assert capacity_of(interface(1000, duplex=psutil.NIC_DUPLEX_HALF)) == 125e6
    assert capacity_of(interface(0)) == 0.0


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    counters = SimpleNamespace(bytes_sent=1000, bytes_recv=500)
    monkeypatch.setattr(psutil, "net_if_stats", lambda: {"eth0": interface()})
    monkeypatch.setattr(psutil, "net_io_counters", lambda pernic: {"eth0": counters})
    return counters


def test_rate_counts_traffic_since_the_last_call(counted: SimpleNamespace) -> None:
    clock = ManualClock()
    load = NetworkLoad(clock)
    counted.bytes_sent += 600
    counted.bytes_recv += 400
    clock.advance(2.0)
    assert (load.capacity, load.rate()) == (250e6, 500.0)
    clock.advance(1.0)
    assert load.rate() == 0.0
    counted.bytes_sent = counted.bytes_recv = 0
    clock.advance(1.0)
    assert load.rate() == 0.0, "the counters of an interface that came back begin anew"


def test_host_without_a_network_has_zero_capacity_and_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(psutil, "net_if_stats", dict)
    monkeypatch.setattr(psutil, "net_io_counters", lambda pernic: {})
    load = NetworkLoad(ManualClock())
    assert (load.capacity, load.rate()) == (0.0, 0.0)
