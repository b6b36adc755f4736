"""Batteries: what metres and seconds cost, learnt from reports that are noisy, jump, and change with the battery's age.

The model is linear: a robot loses charge per metre and per second, and gains it per second at a charger. Its two costs
are estimated by recursive least squares with forgetting (Ljung, "System Identification", 1987), over windows of some
minutes, since reports are often whole percents.
"""

import math
from collections import deque
from dataclasses import dataclass
from statistics import median

import numpy as np

# -- what a battery can do ---------------------------------------------------------------------------------------------

PER_METRE = 1e-4
"""Charge that a metre costs until it is learnt: 10 km."""

PER_SECOND = 2e-5
"""Charge that a second costs until it is learnt: 14 h."""

GAIN = 1.5e-4
"""Charge that a second at a charger brings until it is learnt: 1.9 h."""

METRE_LIMITS = 1e-6, 1e-2
SECOND_LIMITS = 1e-7, 1e-3
GAIN_LIMITS = 1e-5, 1e-2
"""Limits of what is learnt."""


Learnt = tuple[float, float, float]
"""What is stored of a battery: charge per metre, per second, and per second at a charger."""


@dataclass(frozen=True, slots=True)
class Battery:
    """Charge of a battery, and what changes it.

    Parameters
    ----------
    charge : float
        From 0 to 1.
    per_metre, per_second : float
        Charge that a metre and a second cost.
    gain : float
        Charge that a second at a charger brings.
    """

    charge: float
    per_metre: float = PER_METRE
    per_second: float = PER_SECOND
    gain: float = GAIN

    @property
    def learnt(self) -> Learnt:
        """What is to be stored of it."""
        return self.per_metre, self.per_second, self.gain

    def cost(self, metres: float, seconds: float) -> float:
        """Return the charge that driving so far, within so much time, takes."""
        return self.per_metre * metres + self.per_second * seconds

    def after(self, metres: float, seconds: float) -> float:
        """Return the charge after a drive; negative if it is not enough."""
        return self.charge - self.cost(metres, seconds)


# -- what is learnt of it ----------------------------------------------------------------------------------------------

WINDOW = 300.0
"""Time over which a loss of charge is measured [s]."""

SHORT_WINDOW, CLEAR = 30.0, 0.06
"""Least time of a window [s] that ends earlier, since the charge has changed so much: batteries of small robots."""

SAMPLES = 5
"""Number of reports whose median counts: two of them may be wrong."""

MOST_JUMP = 0.08
"""Difference from what was expected of a window from which it says nothing: the battery was changed, or jumps."""

NOISE = 0.01
"""Usual error of the loss in a window; one counts for no more than twice what is to be expected."""

FORGETTING = 0.997
"""Weight of a window once the next has come: a day's windows fade within about two days."""

UNSURE = 1.0
"""Variance of a scaled cost that is not known yet, and its limit, so that long rest makes none unsure."""

KNOWN = 1e-3
"""Variance of a scaled cost that was learnt before a restart: a third of a usual one."""

_METRES, _SECONDS = 1e3, 1e4  # scales: a scaled cost is about 0.1

_LIMITS = np.array([METRE_LIMITS, SECOND_LIMITS]).T * (_METRES, _SECONDS)


class BatteryEstimator:
    """Learns what metres and seconds cost a robot's battery.

    Parameters
    ----------
    learnt : tuple of float, optional
        What was learnt before a restart.
    """

    def __init__(self, learnt: Learnt | None = None) -> None:
        metre, second, gain = learnt or (PER_METRE, PER_SECOND, GAIN)
        self._costs = np.clip([metre * _METRES, second * _SECONDS], *_LIMITS)
        self._variances = np.eye(2) * (UNSURE if learnt is None else KNOWN)
        self._gain = min(max(gain, GAIN_LIMITS[0]), GAIN_LIMITS[1])
        self._recent: deque[float] = deque(maxlen=SAMPLES)
        self._since: tuple[float, float, float] | None = None
        self._charging = False

    @property
    def battery(self) -> Battery | None:
        """What is known of the battery; None before the first report."""
        if not self._recent:
            return None
        metre, second = self._costs
        return Battery(median(self._recent), float(metre) / _METRES, float(second) / _SECONDS, self._gain)

    def see(self, charge: float | None, metres: float, now: float, *, charging: bool) -> None:
        """Note a report.

        Parameters
        ----------
        charge : float, optional
            From 0 to 1; others, and NaN, are no reports.
        metres : float
            Distance that the robot has driven, in all [m].
        now : float
            Monotonic time [s].
        charging : bool
            Whether it is at a charger.
        """
        if charge is None or not 0.0 <= charge <= 1.0:
            return
        self._recent.append(charge)
        if charging != self._charging:
            self._charging, self._since = charging, None
            self._recent.clear()
            self._recent.append(charge)
        if len(self._recent) < SAMPLES:
            return
        known = median(self._recent)
        if self._since is None:
            self._since = now, metres, known
        elif now - self._since[0] >= (WINDOW if abs(known - self._since[2]) < CLEAR else SHORT_WINDOW):
            self._learn(now - self._since[0], metres - self._since[1], self._since[2] - known)
            self._since = now, metres, known

    def _learn(self, seconds: float, metres: float, loss: float) -> None:
        if self._charging:
            self._learn_gain(seconds, -loss)
            return
        drive = np.array([metres / _METRES, seconds / _SECONDS])
        error = loss - float(self._costs @ drive)
        if abs(error) > MOST_JUMP or not math.isfinite(error):
            return
        spread = self._variances @ drive
        gain = spread / (FORGETTING * NOISE**2 + float(drive @ spread))
        most = 2.0 * math.sqrt(NOISE**2 + float(drive @ spread))
        self._costs += gain * min(max(error, -most), most)
        self._costs = np.clip(self._costs, *_LIMITS)
        spread_out = (self._variances - np.outer(gain, spread)) / FORGETTING
        self._variances = spread_out * min(1.0, UNSURE / float(np.trace(spread_out)))

    def _learn_gain(self, seconds: float, risen: float) -> None:
        gain = risen / seconds
        if GAIN_LIMITS[0] <= gain <= GAIN_LIMITS[1]:  # a full battery gains nothing, and a jump too much
            self._gain += 0.2 * (gain - self._gain)
