"""Simulated battery of a robot: it is charged by chargers, discharged by driving, and measured with noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.sensor_msgs import BatteryState, PowerSupplyStatus
from robots.sim.docks.charger import Charger

EMPTY, FULL_VOLTAGE = 13.2, 16.6
"""Voltage of an empty and of a full battery of four cells [V]."""

FULL = 0.995
"""Charge from which a battery takes no current, as a part of the whole."""


@dataclass(frozen=True, slots=True)
class BatteryModel:
    """Parameters of a battery.

    Parameters
    ----------
    capacity : float
        Charge of a full battery [Ah].
    idle, driving : float
        Current of a robot that stands, and in addition per speed [A, A per m/s].
    noise : float
        Standard deviation of a measured current [A].
    measures_current : bool
        Whether the robot measures its current; else only the charge and the status.
    """

    capacity: float = 5.0
    idle: float = 0.9
    driving: float = 2.0
    noise: float = 0.2
    measures_current: bool = True


class SimulatedBattery:
    """Battery of one robot.

    Parameters
    ----------
    chargers : sequence of Charger
        Chargers of its world.
    rng : numpy.random.Generator
        Random generator of the noise.
    model : BatteryModel, optional
    charge : float
        Charge at the start, as a part of the whole.

    Attributes
    ----------
    charge : float
        True charge, as a part of the whole.
    flow : float
        True current, negative when discharging [A].
    """

    def __init__(
        self, chargers: Sequence[Charger], rng: np.random.Generator, model: BatteryModel | None = None,
        charge: float = 0.5,
    ) -> None:  # fmt: skip
        self._chargers, self._rng, self._model = chargers, rng, model or BatteryModel()
        self.charge, self.flow = charge, 0.0
        self._reports = False

    def step(self, robot: Pose2D, speed: float, seconds: float) -> None:
        """Charge or discharge it for a time [s], in a robot at a pose with a speed [m/s]."""
        model = self._model
        given = sum(charger.current(robot) for charger in self._chargers)
        self._reports = any(charger.reports_charging(robot) for charger in self._chargers)
        drain = model.idle + model.driving * abs(speed)
        self.flow = (0.0 if self.charge >= FULL else given) if given > 0.0 else -drain
        self.charge = min(max(self.charge + self.flow * seconds / 3600.0 / model.capacity, 0.0), 1.0)

    def message(self, stamp: float) -> BatteryState:
        """Return the measured state."""
        status = PowerSupplyStatus.POWER_SUPPLY_STATUS_DISCHARGING
        if self._reports:
            full = self.charge >= FULL
            status = PowerSupplyStatus.POWER_SUPPLY_STATUS_CHARGING
            status = PowerSupplyStatus.POWER_SUPPLY_STATUS_FULL if full else status
        measured = self.flow + self._model.noise * float(self._rng.standard_normal())
        return BatteryState(
            Header(stamp=Time.of(stamp)),
            voltage=EMPTY + self.charge * (FULL_VOLTAGE - EMPTY),
            current=measured if self._model.measures_current else None,
            capacity=self._model.capacity,
            percentage=self.charge,
            power_supply_status=int(status),
            present=True,
        )
