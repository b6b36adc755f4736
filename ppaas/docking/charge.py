"""Verdicts on batteries: charged or not, by their current, or by their status where no current is measured."""

from collections import deque
from collections.abc import Sequence
from enum import Enum
from statistics import median
from typing import NamedTuple

from ppaas.docking.failures import BatterySilent, ChargerLies, ContactWithoutCharge, DockingFailure
from ppaas.messages.sensor_msgs import PowerSupplyStatus

CHARGING = int(PowerSupplyStatus.POWER_SUPPLY_STATUS_CHARGING)
FULL = int(PowerSupplyStatus.POWER_SUPPLY_STATUS_FULL)

LEAST = 3
"""Least number of readings that say anything: single ones are noise."""

MOST = 9
"""Number of newest readings that count."""

KEPT = 2000
"""Largest number of readings that are kept."""

FALL = 0.01
"""Loss of charge that shows that a battery is discharged, as a part of the whole."""


class ChargeReading(NamedTuple):
    """What a robot measures of its battery.

    Parameters
    ----------
    at : float
        Time of arrival [s].
    current : float, optional
        Negative when discharging [A].
    percentage : float, optional
        Charge from 0 to 1.
    status : int
        ``power_supply_status``.
    """

    at: float
    current: float | None = None
    percentage: float | None = None
    status: int = 0


class ChargeVerdict(Enum):
    """What readings of a battery say."""

    SILENT = "nothing is known of the battery"
    UNDECIDED = "there are too few readings of the battery"
    CHARGING = "the battery is charged"
    NOT_CHARGING = "the battery is not charged"
    LIES = "the battery reports that it is charged, while it is discharged"


class ChargeWatch:
    """Keeps readings of a battery, and judges those since a time.

    Parameters
    ----------
    threshold : float
        Current from which the battery counts as charged [A].
    """

    def __init__(self, threshold: float) -> None:
        self._threshold = threshold
        self._readings: deque[ChargeReading] = deque(maxlen=KEPT)

    def take(self, reading: ChargeReading) -> None:
        """Take a reading."""
        self._readings.append(reading)

    def since(self, begin: float) -> list[ChargeReading]:
        """Return the readings since a time [s]."""
        return [each for each in self._readings if each.at >= begin]

    def verdict(self, begin: float) -> ChargeVerdict:
        """Return what the newest of the readings since a time [s] say."""
        return verdict_of(self.since(begin), self._threshold)

    def current(self, begin: float) -> float | None:
        """Return the median of the newest currents since a time [s]; None if none is measured."""
        return _median([each.current for each in self.since(begin)[-MOST:]])


def verdict_of(readings: Sequence[ChargeReading], threshold: float) -> ChargeVerdict:
    """Return what readings of a battery say, oldest first; ``threshold`` is a current [A].

    A full battery takes no current. The median of several readings is meant wherever a number is compared, so that
    noise and a battery that jumps for a moment change nothing.
    """
    if len(readings) < LEAST:
        return ChargeVerdict.UNDECIDED if readings else ChargeVerdict.SILENT
    newest = readings[-MOST:]
    says_full, says_charging = _most(newest, FULL), _most(newest, CHARGING, FULL)
    current, falls = _median([each.current for each in newest]), has_fallen(readings)
    if current is None:
        charged, discharged = says_charging and not falls, falls
    else:
        charged = not falls and (current >= threshold or (says_full and current > -threshold))
        discharged = falls or current <= -threshold
    if charged:
        return ChargeVerdict.CHARGING
    return ChargeVerdict.LIES if says_charging and discharged else ChargeVerdict.NOT_CHARGING


def _most(readings: Sequence[ChargeReading], *statuses: int) -> bool:
    """Return whether most of the readings have one of the statuses."""
    return 2 * sum(each.status in statuses for each in readings) > len(readings)


def has_fallen(readings: Sequence[ChargeReading]) -> bool:
    """Return whether the charge of a battery has fallen from the first of its readings to the last ones."""
    known = [each.percentage for each in readings if each.percentage is not None]
    if len(known) < 2 * LEAST:
        return False
    count = min(MOST, len(known) // 2)
    return median(known[:count]) - median(known[-count:]) >= FALL


def _median(values: Sequence[float | None]) -> float | None:
    known = [each for each in values if each is not None]
    return median(known) if len(known) >= LEAST else None


def uncharged(where: str, verdict: ChargeVerdict, current: float | None) -> DockingFailure:
    """Return the failure of a robot that stands at a dock, by the verdict on its battery, and the current [A]."""
    measured = "" if current is None else f" ({current:+.2f} A)"
    if verdict is ChargeVerdict.LIES:
        return ChargerLies(f"at {where} the battery reports that it is charged, while it is discharged{measured}")
    if verdict is ChargeVerdict.NOT_CHARGING:
        return ContactWithoutCharge(f"the robot stands at {where}, and its battery is not charged{measured}")
    return BatterySilent(f"the robot stands at {where}, and too little is known of its battery: publish battery_state")
