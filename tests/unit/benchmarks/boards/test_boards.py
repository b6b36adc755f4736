"""The bench of boards measures both clients."""

import shutil

import pytest

from benchmarks.boards import measurement
from tests.support.cloud import board_robot


@pytest.mark.skipif(
    board_robot.micropython() is None, reason="MicroPython is not installed: it has wheels for Linux only"
)
async def test_a_board_with_micropython_sends_its_scans_from_a_small_heap() -> None:
    figures = {figure.name: figure for figure in await measurement.measure_micropython(quick=True)}
    assert figures["scans a second"].value > 0.0 and figures["scans a second"].floor
    assert figures["heap in use after a collection"].value < 32.0
    assert figures["allocated by a scan"].value == 0
    assert [figure.yardstick for figure in figures.values()].count(True) == 2


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is not installed")
def test_a_board_with_arduino_fits_in_its_memory() -> None:
    figures = {figure.name: figure for figure in measurement.measure_arduino(quick=True)}
    assert 1000 < figures["RAM of a robot"].value < 20_000
    assert all(figure.value > 0.0 for figure in figures.values())
