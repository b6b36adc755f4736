"""The benchmark of a computer runs once and is cached."""

import json
from pathlib import Path

import pytest

from robots.onboard import computer
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
