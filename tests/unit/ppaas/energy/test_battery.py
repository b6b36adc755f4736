"""What metres and seconds cost is learnt in spite of noise, jumps and age."""

import math

import numpy as np
import pytest

from ppaas.energy.battery import GAIN_LIMITS, METRE_LIMITS, PER_METRE, SECOND_LIMITS, Battery, BatteryEstimator


class Robot:
    """A robot that works and rests by turns, and whose battery reports whole percents with errors."""

    def __init__(self, per_metre: float, per_second: float, seed: int = 1) -> None:
        self.model, self.rng = BatteryEstimator(), np.random.default_rng(seed)
        self.per_metre, self.per_second = per_metre, per_second
        self.now = self.metres = 0.0
        self.charge = 1.0

    def live(self, hours: float, *, faults: bool = True) -> None:
        for _ in range(int(hours * 360.0)):
            self.now += 10.0
            speed = 0.5 if int(self.now / 1500.0) % 3 else 0.0
            self.metres += 10.0 * speed
            self.charge -= self.per_metre * 10.0 * speed + self.per_second * 10.0
            if self.charge < 0.2:  # its battery is changed
                self.charge = 1.0
            self.model.see(self.reported(faults), self.metres, self.now, charging=False)

    def reported(self, faults: bool) -> float:
        said = round(self.charge + self.rng.normal(0.0, 0.01), 2)
        if faults and self.rng.random() < 0.05:
            return float(self.rng.choice([math.nan, -1.0, 0.0, 1.0, 73.0]))
        return said

    def error(self) -> float:
        battery = self.model.battery
        assert battery is not None
        true, found = (cost.cost(1000.0, 3000.0) for cost in (Battery(1.0, self.per_metre, self.per_second), battery))
        return abs(found - true) / true


@pytest.mark.parametrize(
    ("per_metre", "per_second"), [(1e-4, 2e-5), (4e-4, 2e-5), (2e-5, 1e-5), (1e-4, 1e-4), (1e-3, 5e-5)]
)
def test_costs_are_learnt_within_a_tenth_in_a_day(per_metre: float, per_second: float) -> None:
    robot = Robot(per_metre, per_second)
    robot.live(24.0)
    assert robot.error() < 0.1


def test_an_older_battery_is_followed() -> None:
    robot = Robot(1e-4, 2e-5)
    robot.live(24.0)
    robot.per_metre, robot.per_second = 2e-4, 4e-5
    robot.live(36.0)
    assert robot.error() < 0.12


def test_the_charge_is_the_median_and_rest_makes_nothing_unsure() -> None:
    robot = Robot(1e-4, 2e-5)
    robot.live(24.0, faults=False)
    for number in range(20_000):  # reports of a robot that stands still with a battery that is always full
        robot.model.see(1.0, robot.metres, robot.now + 10.0 * number, charging=False)
    known = robot.model.battery
    assert known is not None
    assert known.charge == 1.0
    assert METRE_LIMITS[0] <= known.per_metre <= 3.0 * PER_METRE
    assert known.per_second == pytest.approx(SECOND_LIMITS[0], abs=1e-5)
    robot.model.see(0.0, robot.metres, 1e6, charging=False)
    assert robot.model.battery == known


def test_a_charger_teaches_its_gain_and_not_the_costs_of_driving() -> None:
    model = BatteryEstimator()
    assert model.battery is None
    for number in range(600):
        model.see(min(1.0, 0.2 + 3e-4 * 10.0 * number), 0.0, 10.0 * number, charging=True)
    battery = model.battery
    assert battery is not None
    assert battery.gain == pytest.approx(3e-4, rel=0.15)
    assert (battery.per_metre, battery.charge) == (PER_METRE, 1.0)
    assert GAIN_LIMITS[0] <= battery.gain <= GAIN_LIMITS[1]


def test_charge_after_a_drive_may_be_negative() -> None:
    battery = Battery(0.5, per_metre=1e-3, per_second=1e-4)
    assert battery.after(100.0, 200.0) == pytest.approx(0.38)
    assert battery.after(600.0, 0.0) < 0.0


def test_what_was_learnt_is_known_after_a_restart_and_noise_does_not_lose_it() -> None:
    robot = Robot(4e-4, 2e-5)
    robot.live(24.0)
    assert robot.model.battery is not None
    robot.model = BatteryEstimator(robot.model.battery.learnt)
    for _ in range(12):
        robot.live(0.5)
        assert robot.error() < 0.15


def test_another_battery_is_learnt_in_place_of_the_one_that_is_known() -> None:
    robot = Robot(4e-4, 2e-5)
    robot.model = BatteryEstimator((2e-4, 4e-5, 1e-4))
    robot.live(24.0)
    assert robot.error() < 0.1


def test_what_was_stored_is_limited() -> None:
    estimator = BatteryEstimator((1e9, -1.0, 1e9))
    estimator.see(0.5, 0.0, 0.0, charging=False)
    assert estimator.battery is not None
    assert estimator.battery.learnt == pytest.approx((METRE_LIMITS[1], SECOND_LIMITS[0], GAIN_LIMITS[1]))
