"""Simulated batteries."""

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages import decode, encode
from ppaas.messages.sensor_msgs import BatteryState
from robots.sim.docks.battery import BatteryModel, SimulatedBattery
from robots.sim.docks.charger import Charger, ChargerFault

DOCKED, AWAY = Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0)


def battery(fault: ChargerFault = ChargerFault.NOTHING, charge: float = 0.5, **model: object) -> SimulatedBattery:
    rng = np.random.default_rng(0)
    return SimulatedBattery([Charger(DOCKED, 0.2, fault=fault)], rng, BatteryModel(**model), charge)  # type: ignore[arg-type]


def test_a_battery_is_discharged_faster_by_driving_and_charged_at_a_dock() -> None:
    standing, driving, charging = battery(), battery(), battery()
    for _ in range(600):
        standing.step(AWAY, 0.0, 1.0)
        driving.step(AWAY, 0.5, 1.0)
        charging.step(DOCKED, 0.0, 1.0)
    assert driving.charge < standing.charge < 0.5 < charging.charge
    assert charging.charge - 0.5 == pytest.approx(3.0 * 600 / 3600 / 5.0)


def test_a_charge_stays_between_empty_and_full() -> None:
    empty, full = battery(charge=0.001), battery(charge=0.99)
    for _ in range(3000):
        empty.step(AWAY, 0.5, 1.0)
        full.step(DOCKED, 0.0, 1.0)
    assert empty.charge == 0.0
    assert 0.995 <= full.charge <= 1.0
    assert full.message(1.0).power_supply_status == 4


@pytest.mark.parametrize(
    ("fault", "at", "status"),
    [
        (ChargerFault.NOTHING, DOCKED, 1),
        (ChargerFault.NOTHING, AWAY, 2),
        (ChargerFault.DEAD, DOCKED, 2),
        (ChargerFault.LIAR, DOCKED, 1),
    ],
)
def test_a_battery_reports_what_its_charger_says(fault: ChargerFault, at: Pose2D, status: int) -> None:
    made = battery(fault)
    made.step(at, 0.0, 1.0)
    assert made.message(1.0).power_supply_status == status
    assert (made.flow > 0.0) is (fault is ChargerFault.NOTHING and at == DOCKED)


def test_currents_are_measured_with_noise_or_not_at_all() -> None:
    noisy, blind = battery(noise=0.5), battery(measures_current=False)
    noisy.step(DOCKED, 0.0, 1.0)
    blind.step(DOCKED, 0.0, 1.0)
    currents = [noisy.message(1.0).current or 0.0 for _ in range(200)]
    assert np.mean(currents) == pytest.approx(3.0, abs=0.15)
    assert np.std(currents) == pytest.approx(0.5, abs=0.1)
    state = blind.message(2.5)
    assert state.current is None and state.percentage == blind.charge
    assert decode(BatteryState, encode(state)) == state
