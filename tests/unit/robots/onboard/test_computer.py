"""The benchmark of a computer runs once and is cached."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.controllers.base import Velocity
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.onboard import computer
from robots.onboard.base_controller import STOP, BaseController, BaseLimits
from robots.onboard.computer import REFERENCE_CLOCK, REFERENCE_SECONDS, clock_rate, kernel, measure, this_computer


def test_the_kernel_is_deterministic() -> None:
    assert kernel(1000, 100) == kernel(1000, 100)
    assert kernel(1000, 100) != kernel(1000, 101)


def test_measure_takes_the_best_of_several_rounds() -> None:
    seconds = iter([0.0, 9.0, 10.0, 10.0 + REFERENCE_SECONDS / 2] + [20.0, 29.0] * 5)
    assert measure(lambda: next(seconds)) == pytest.approx(2.0)


def test_the_computer_is_measured_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "deep" / "benchmark.json"
    first = this_computer(cache)
    assert first.benchmark > 0.0
    assert first.cores >= 1
    monkeypatch.setattr(computer, "measure", lambda: pytest.fail("measured again"))
    assert this_computer(cache) == first


@pytest.mark.parametrize("kept", [b"", b"[]", b'{"other": 3.0}', b"\xff", b"null"])
def test_an_invalid_or_foreign_cache_is_ignored(kept: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "benchmark.json"
    cache.write_bytes(kept)
    monkeypatch.setattr(computer, "measure", lambda: 4.25)
    assert this_computer(cache).benchmark == 4.25
    assert list(json.loads(cache.read_bytes()).values()) == [4.25]


def test_an_unwritable_cache_is_logged_and_the_computer_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(computer, "measure", lambda: 4.25)
    assert this_computer(tmp_path / "file" / "benchmark.json").benchmark == 4.25
    assert "cannot cache the benchmark" in caplog.text


def test_clock_rate_is_read_from_linux(tmp_path: Path) -> None:
    frequency, info = tmp_path / "frequency", tmp_path / "info"
    assert clock_rate(frequency, info) == REFERENCE_CLOCK
    info.write_text("processor : 0\ncpu MHz\t\t: 2400.5\n")
    assert clock_rate(frequency, info) == 2.4005
    frequency.write_text("1800000\n")
    assert clock_rate(frequency, info) == 1.8


def twist(linear: float, angular: float) -> Twist:
    return Twist(Vector3(x=linear), Vector3(z=angular))


def test_the_last_command_applies_until_it_expires() -> None:
    clock = ManualClock(100.0)
    base = BaseController(BaseLimits(timeout=0.5), clock)
    assert base.velocity() == STOP
    base.command(twist(0.1, 0.2))
    base.command(twist(0.3, -0.4))
    clock.advance(0.5)
    assert base.velocity() == Velocity(0.3, -0.4)
    clock.advance(0.01)
    assert base.velocity() == STOP


@given(st.floats(allow_nan=False, allow_infinity=False), st.floats(allow_nan=False, allow_infinity=False))
def test_commands_are_clamped_to_the_limits(linear: float, angular: float) -> None:
    limits = BaseLimits(max_linear=0.65, max_angular=3.0)
    base = BaseController(limits, ManualClock())
    base.command(twist(linear, angular))
    velocity = base.velocity()
    assert abs(velocity.linear) <= limits.max_linear
    assert abs(velocity.angular) <= limits.max_angular
    assert velocity.linear == linear or abs(linear) > limits.max_linear
    assert velocity.angular == angular or abs(angular) > limits.max_angular


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused_and_stops_the_base(bad: float) -> None:
    base = BaseController(clock=ManualClock())
    for command in (twist(bad, 0.0), twist(0.0, bad)):
        base.command(twist(0.2, 0.0))
        with pytest.raises(InvalidInput, match="finite"):
            base.command(command)
        assert base.velocity() == STOP


@pytest.mark.parametrize("values", [{"timeout": 0.0}, {"max_linear": -1.0}, {"max_angular": math.nan}])
def test_limits_must_be_positive(values: dict[str, float]) -> None:
    with pytest.raises(InvalidParameter, match=next(iter(values))):
        BaseLimits(**values)
