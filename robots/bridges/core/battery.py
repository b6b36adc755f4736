"""Charge in ``sensor_msgs/BatteryState``, which the cloud passes on without a check."""

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import MalformedMessage

CHARGING = 1
"""``power_supply_status`` of a battery that is charged."""


class Charge(msgspec.Struct):
    """Charge of a battery.

    Parameters
    ----------
    percentage : float, optional
        From 0 to 1.
    power_supply_status : int
    """

    percentage: float | None = None
    power_supply_status: int = 0


def charge_of(message: bytes) -> Charge | None:
    """Return the charge in a message given as JSON; None if the robot does not know it.

    Raises
    ------
    MalformedMessage
        The message has other fields than a BatteryState.
    """
    try:
        charge = from_json(message, Charge)
    except msgspec.DecodeError as error:
        raise MalformedMessage(f"battery_state is not a sensor_msgs/BatteryState: {error}") from error
    return None if charge.percentage is None else charge
