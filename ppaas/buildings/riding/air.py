"""Heights by the pressure of the air, as barometers measure it."""

import math

from ppaas.errors import InvalidInput

GAS, LOWEST, HIGHEST = 8434.0, 30_000.0, 120_000.0
"""Height in which the pressure of the air falls to 1/e at 15 °C [m], and the range of pressures on Earth [Pa]."""


def check_pressure(pascal: float) -> None:
    """Raise ``InvalidInput`` if a number is no pressure of the air on Earth [Pa]."""
    if not LOWEST <= pascal <= HIGHEST:
        raise InvalidInput(f"a pressure of the air is {LOWEST:g} to {HIGHEST:g} Pa, not {pascal:g}")


def height_between(below: float, above: float) -> float:
    """Return the height between two pressures [Pa] of the same weather [m]: positive if the second is less.

    Raises
    ------
    InvalidInput
        A pressure is none of the air on Earth.
    """
    check_pressure(below)
    check_pressure(above)
    return GAS * math.log(below / above)
