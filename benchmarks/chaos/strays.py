"""Times in which a robot was far from where its clone believed it to be."""

from benchmarks.chaos.silences import Gap

FAR = 1.0
"""Distance between a robot and the pose that its clone publishes from which the robot counts as astray [m]."""


class Strays:
    """Times in which one robot was astray."""

    def __init__(self) -> None:
        self._since: float | None = None
        self.gaps: list[Gap] = []

    def look(self, metres: float, now: float) -> None:
        """Record the distance between the robot and its believed pose [m] at a time [monotonic s]."""
        if metres < FAR:
            self.end(now)
        elif self._since is None:
            self._since = now

    def end(self, now: float) -> None:
        """Record that the robot has left, or was found again."""
        if self._since is not None:
            self.gaps.append(Gap(self._since, now))
        self._since = None
