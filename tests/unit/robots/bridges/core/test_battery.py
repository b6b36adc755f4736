"""Charge in messages of batteries that the cloud has not checked."""

import pytest

from ppaas.errors import MalformedMessage
from robots.bridges.core.battery import CHARGING, charge_of


def test_the_charge_is_read() -> None:
    charge = charge_of(b'{"percentage": 0.25, "power_supply_status": 1, "cell_voltage": [3.7, null]}')
    assert charge is not None
    assert (charge.percentage, charge.power_supply_status) == (0.25, CHARGING)


@pytest.mark.parametrize("message", [b"{}", b'{"percentage": null}'])
def test_a_robot_may_not_know_its_charge(message: bytes) -> None:
    assert charge_of(message) is None


@pytest.mark.parametrize("message", [b"null", b"[]", b"7", b'{"percentage": "full"}', b"{", b"\xff"])
def test_what_is_no_message_of_a_battery_is_refused(message: bytes) -> None:
    with pytest.raises(MalformedMessage, match="BatteryState"):
        charge_of(message)
