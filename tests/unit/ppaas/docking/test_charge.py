"""Whether a battery is charged, by noisy readings of it."""

import pytest

from ppaas.docking.charge import CHARGING, FULL, ChargeReading, ChargeVerdict, ChargeWatch, verdict_of

DISCHARGING = 2


def readings(
    *currents: float | None, status: int = DISCHARGING, percentages: tuple[float, ...] = ()
) -> list[ChargeReading]:
    shares = [*percentages, *[None] * (len(currents) - len(percentages))]
    return [
        ChargeReading(float(at), current, share, status)
        for at, (current, share) in enumerate(zip(currents, shares, strict=True))
    ]


@pytest.mark.parametrize(
    ("given", "verdict"),
    [
        ([], ChargeVerdict.SILENT),
        (readings(3.0, 3.0, status=CHARGING), ChargeVerdict.UNDECIDED),
        (readings(3.0, 2.8, 3.1), ChargeVerdict.CHARGING),
        (readings(-0.9, -1.1, -0.8), ChargeVerdict.NOT_CHARGING),
        (readings(0.1, 0.2, 0.0, status=CHARGING), ChargeVerdict.NOT_CHARGING),
        (readings(-0.9, -1.1, -0.8, status=CHARGING), ChargeVerdict.LIES),
        (readings(0.0, 0.1, -0.1, status=FULL), ChargeVerdict.CHARGING),
        (readings(None, None, None, status=CHARGING), ChargeVerdict.CHARGING),
        (readings(None, None, None), ChargeVerdict.NOT_CHARGING),
        (readings(3.0, -60.0, 3.0, 2.9, 3.1), ChargeVerdict.CHARGING),
        (readings(-0.9, 40.0, -1.0, -0.9), ChargeVerdict.NOT_CHARGING),
    ],
)
def test_readings_are_judged(given: list[ChargeReading], verdict: ChargeVerdict) -> None:
    assert verdict_of(given, 0.5) is verdict


def test_a_battery_that_falls_while_it_reports_charge_lies() -> None:
    falling = tuple(0.5 - 0.004 * each for each in range(8))
    told = readings(*[None] * 8, status=CHARGING, percentages=falling)
    assert verdict_of(told, 0.5) is ChargeVerdict.LIES
    assert verdict_of(readings(*[2.0] * 8, status=CHARGING, percentages=falling), 0.5) is ChargeVerdict.LIES


def test_a_charge_that_jumps_for_a_moment_does_not_fall() -> None:
    jumps = (0.5, 0.5, 0.51, 0.1, 0.51, 0.51, 0.52, 0.52)
    assert verdict_of(readings(*[2.0] * 8, percentages=jumps), 0.5) is ChargeVerdict.CHARGING


def test_only_readings_since_a_time_count() -> None:
    watch = ChargeWatch(0.5)
    for each in readings(-1.0, -1.0, -1.0, -1.0, 2.0, 2.0, 2.0):
        watch.take(each)
    assert watch.verdict(0.0) is ChargeVerdict.NOT_CHARGING
    assert watch.verdict(4.0) is ChargeVerdict.CHARGING
    assert watch.current(4.0) == 2.0
    assert watch.verdict(9.0) is ChargeVerdict.SILENT
