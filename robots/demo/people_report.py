"""Report of the demo of people."""

import msgspec

from robots.demo.people_score import PeopleFigures

KEYS = (
    "count_error_mean", "count_exact", "identity_switches", "followed_fraction", "handovers", "flaps", "contacts",
)  # fmt: skip
"""Figures of the JSON object, in order."""


class PeopleDemoReport(msgspec.Struct):
    """Report of a demo in which robots count and follow people.

    Parameters
    ----------
    map : str
        Id of the map.
    seconds : float
        Time that was scored [s].
    robots, people : int
        Numbers of robots and people.
    figures : PeopleFigures
    """

    map: str
    seconds: float
    robots: int
    people: int
    figures: PeopleFigures

    @property
    def passed(self) -> bool:
        """Whether somebody was seen and followed, without a contact, and no handover was reverted soon."""
        figures = self.figures
        return figures.seen > 0.0 and figures.followed_fraction > 0.0 and not figures.contacts and not figures.flaps

    def to_json(self) -> str:
        """Return the figures as one line of JSON."""
        return msgspec.json.encode({key: getattr(self.figures, key) for key in KEYS}).decode()

    def lines(self) -> list[str]:
        """Return the report for people."""
        figures = self.figures
        return [
            f"{self.robots} robots and {self.people} people, {figures.seen:.1f} of them in view on average",
            f"the count was exact {100 * figures.count_exact:.1f} % of the time, and {figures.count_error_mean:.2f} "
            f"off on average; {figures.identity_switches} identity switches",
            f"a robot was near the person followed {100 * figures.followed_fraction:.1f} % of the time; "
            f"{figures.handovers} handovers, {figures.flaps} of them reverted within 5 s; {figures.contacts} contacts",
            f"{'passed' if self.passed else 'failed'} after {self.seconds:.0f} s on map {self.map!r}",
        ]
