"""On which floor a robot leaves a lift, from all that is known: the lift's word, a barometer, and scans.

None of them is trusted alone. Lifts say nothing, or are wrong; the air pressure changes with the weather; floors look
alike. Each adds its evidence, as the logarithm of its likelihood, and a floor is known once it is far more likely than
all others together.
"""

import math
from collections.abc import Mapping

from ppaas.buildings.riding.air import check_pressure, height_between
from ppaas.errors import InvalidInput

EXPECTED = 0.9
"""Probability that a robot gets out on the floor that it was sent to, before anything is known."""

TRUST = 0.9
"""Probability that a lift that names a floor is right; lifts that are wrong at times must not decide alone."""

HEIGHT, WEATHER = 0.7, 0.003
"""Standard deviation of a difference of heights by the barometer [m], and what weather adds each second [m/s]."""

SURE = 0.999
"""Probability from which on a floor is known."""


class FloorBelief:
    """Probabilities of the floors at which a lift stops.

    Parameters
    ----------
    elevations : mapping of str to float
        Heights of the floors that the robot may be on [m], by name; at least one.
    origin, destination : str
        Floor at which it came in, and the one to which it was sent.

    Raises
    ------
    InvalidInput
        A floor is not among the elevations.
    """

    def __init__(self, elevations: Mapping[str, float], origin: str, destination: str) -> None:
        for floor in (origin, destination):
            if floor not in elevations:
                raise InvalidInput(f"the lift does not stop at floor {floor!r}, but at {', '.join(elevations)}")
        self._elevations, self._origin = dict(elevations), origin
        others = max(len(elevations) - 1, 1)
        self._logs = {
            floor: math.log(EXPECTED if floor == destination else (1.0 - EXPECTED) / others) for floor in elevations
        }
        self._pressure: tuple[float, float] | None = None
        self._by_height: dict[str, float] = dict.fromkeys(elevations, 0.0)
        self._by_lift: dict[str, float] = dict.fromkeys(elevations, 0.0)
        self._by_scan: dict[str, float] = dict.fromkeys(elevations, 0.0)

    def lift_names(self, floor: str) -> None:
        """Take the floor at which the lift says that it stands; its last word counts, however often it is repeated."""
        if floor not in self._elevations:
            return
        wrong = math.log((1.0 - TRUST) / max(len(self._elevations) - 1, 1))
        self._by_lift = {each: math.log(TRUST) if each == floor else wrong for each in self._elevations}

    def pressure(self, pascal: float, now: float) -> None:
        """Take the pressure of the air [Pa] at a time [s]; the first is at the floor of origin, the last one counts.

        Raises
        ------
        InvalidInput
            It is no pressure of the air on Earth.
        """
        if self._pressure is None:
            check_pressure(pascal)
            self._pressure = pascal, now
            return
        first, since = self._pressure
        risen = height_between(first, pascal)
        spread = math.hypot(HEIGHT, WEATHER * max(now - since, 0.0))
        zero = self._elevations[self._origin]
        self._by_height = {
            floor: max(-0.5 * ((elevation - zero - risen) / spread) ** 2, -20.0)
            for floor, elevation in self._elevations.items()
        }

    def scan(self, likelihoods: Mapping[str, float]) -> None:
        """Take the logarithms of the likelihoods of a scan on the maps of floors; each scan counts."""
        for floor in self._by_scan.keys() & likelihoods.keys():
            self._by_scan[floor] += likelihoods[floor]

    def probabilities(self) -> dict[str, float]:
        """Return the probability of each floor."""
        logs = {
            floor: log + self._by_lift[floor] + self._by_height[floor] + self._by_scan[floor]
            for floor, log in self._logs.items()
        }
        most = max(logs.values())
        shares = {floor: math.exp(log - most) for floor, log in logs.items()}
        together = sum(shares.values())
        return {floor: share / together for floor, share in shares.items()}

    @property
    def likeliest(self) -> str:
        """The floor with the highest probability."""
        found = self.probabilities()
        return max(found, key=found.__getitem__)

    @property
    def known(self) -> str | None:
        """The floor that the robot is on; None while that is not known."""
        found = self.probabilities()
        best = max(found, key=found.__getitem__)
        return best if found[best] >= SURE else None
