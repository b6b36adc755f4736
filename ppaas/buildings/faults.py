"""Faults of lifts and doors that last: each is reported once, and once more when it is over."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

PATIENCE = 5.0
"""Time for which a fault lasts before it is reported [s]: devices are asked again after short failures."""


class PartName(NamedTuple):
    """Lift or door of a building; ``floor`` is the floor of a door, and empty for a lift."""

    kind: Literal["lift", "door"]
    name: str
    floor: str = ""


class FaultChange(NamedTuple):
    """A lift or a door has a fault, or serves again if ``text`` is empty."""

    part: PartName
    text: str

    @property
    def sentence(self) -> str:
        """The change in words."""
        if self.text:
            return self.text
        where = f" of floor {self.part.floor!r}" if self.part.floor else ""
        return f"{self.part.kind} {self.part.name!r}{where} serves again"


class FaultWatch:
    """Watches lifts and doors."""

    def __init__(self) -> None:
        self._since: dict[tuple[PartName, str], float] = {}
        self._reported: dict[PartName, str] = {}

    def look(self, faults: Mapping[PartName, str], now: float) -> list[FaultChange]:
        """Return what has changed, given the fault of each part, empty for none, at a time [s]."""
        self._since = {(part, text): self._since.get((part, text), now) for part, text in faults.items()}
        changes = []
        for (part, text), since in self._since.items():
            lasts = not text or now - since >= PATIENCE
            if lasts and text != self._reported.get(part, ""):
                self._reported[part] = text
                changes.append(FaultChange(part, text))
        return changes
