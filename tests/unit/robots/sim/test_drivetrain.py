import math

import numpy as np
import pytest

from ppaas.controllers.base import Velocity
from robots.sim.drivetrain import Drivetrain, DrivetrainModel

DT = 0.01


def driven(model: DrivetrainModel, seconds: float) -> list[Velocity]:
    drive = Drivetrain(model, np.random.default_rng(0))
    drive.command(Velocity(1.0, 1.0))
    return [drive.turn(DT) for _ in range(round(seconds / DT))]


def test_acceleration_and_speed_are_limited() -> None:
    speeds = driven(DrivetrainModel(0.5, 0.8, 1.0, 2.0), 1.0)
    assert np.abs(np.diff([(0.0, 0.0), *speeds], axis=0)).max(axis=0) == pytest.approx((0.01, 0.02))
    assert speeds[-1] == pytest.approx((0.5, 0.8))


def test_commands_are_delayed_and_motors_lag() -> None:
    speeds = driven(DrivetrainModel(2.0, 2.0, 1e3, 1e3, lag=0.1, delay=0.2), 1.0)
    assert all(speed == (0.0, 0.0) for speed in speeds[:20])
    assert speeds[20].linear > 0.0
    assert speeds[29].linear == pytest.approx(1.0 - math.exp(-1.0), abs=1e-6)


def test_commands_are_applied_in_order() -> None:
    drive = Drivetrain(DrivetrainModel(2.0, 2.0, 1e3, 1e3, delay=0.05), np.random.default_rng(0))
    speeds = []
    for step in range(20):
        drive.command(Velocity(float(step) / 10.0, 0.0))
        speeds.append(drive.turn(DT).linear)
    assert speeds[:5] == [0.0] * 5
    assert speeds[5:] == pytest.approx([step / 10.0 for step in range(15)])


def test_wheels_slip_as_configured_without_an_effect_on_odometry() -> None:
    model = DrivetrainModel(2.0, 2.0, 1e3, 1e3, slip_linear=0.05, slip_angular=0.15, slip_time=0.02)
    speeds = np.array(driven(model, 100.0))
    assert speeds.std(axis=0) == pytest.approx((0.05, 0.15), rel=0.1)
    drive = Drivetrain(model, np.random.default_rng(0))
    drive.command(Velocity(1.0, 1.0))
    drive.turn(DT)
    assert drive.wheels == (1.0, 1.0)
