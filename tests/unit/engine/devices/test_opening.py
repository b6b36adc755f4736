import pytest

from engine.devices.base import DeviceUrl
from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.building import DoorSettings, LiftSettings
from ppaas.errors import InvalidInput, NotPermitted, Unavailable

LEVELS = {"L1": 0.0, "L2": 3.0}


@pytest.mark.parametrize(
    ("url", "text"),
    [
        ("", "unknown scheme"),
        ("ftp://10.0.0.7", "unknown scheme of a device 'ftp'; known: http:"),
        ("http:", "has a host"),
        ("http://user:secret@10.0.0.7", "may have no password"),
        ("http://[", "not valid"),
        ("http://h:99999", "not valid"),
        ("sim:?people=many", "'people' of a device is a number"),
        ("sim:?speed=1", "has no option 'speed'; options: people"),
    ],
)
def test_a_url_that_is_not_valid_is_refused(url, text):
    with pytest.raises(InvalidInput, match=text):
        open_lift(LiftSettings(lift="A", device=url), LEVELS, DeviceHosts())


def test_doors_take_fewer_options_than_lifts():
    with pytest.raises(InvalidInput, match="people"):
        open_door(DoorSettings(floor="L1", door="main", device="sim:?people=1"), DeviceHosts())


def test_floors_have_the_names_of_the_device():
    url = DeviceUrl.parse("http://h/?floors=L1:0,Attic:7")
    assert (url.theirs("Attic"), url.ours("0"), url.theirs("other"), url.ours("9")) == ("7", "L1", "other", "9")


async def test_hosts_are_listed_by_name_address_network_and_port():
    hosts = DeviceHosts(["Lift.example", "10.0.0.7:502", "192.168.3.0/24", "[fd00::1]:80", "fd00::2"])
    assert await hosts.address("lift.example", 8080) == "lift.example"
    assert await hosts.address("10.0.0.7", 502) == "10.0.0.7"
    assert await hosts.address("192.168.3.99", 1883) == "192.168.3.99"
    assert await hosts.address("fd00::1", 80) == "fd00::1"
    assert await hosts.address("fd00::2", 443) == "fd00::2"
    for host, port in (("10.0.0.7", 80), ("192.168.4.1", 80), ("fd00::1", 81), ("127.0.0.1", 80)):
        with pytest.raises(NotPermitted):
            await hosts.address(host, port)


async def test_a_name_that_is_not_listed_may_resolve_to_an_address_that_is():
    assert await DeviceHosts(["127.0.0.0/8"]).address("localhost", 80) == "127.0.0.1"
    with pytest.raises(Unavailable, match="cannot be resolved"):
        await DeviceHosts(["127.0.0.0/8"]).address("nowhere.invalid", 80)


async def test_no_host_is_listed_by_default():
    with pytest.raises(NotPermitted, match="has not listed"):
        await DeviceHosts().address("localhost", 80)


@pytest.mark.parametrize("text", ["", "10.0.0.0/99", "a b", "h:0", "h:x", "10.0.0.1/8"])
def test_a_host_of_another_form_is_refused(text):
    with pytest.raises(InvalidInput):
        DeviceHosts([text])
