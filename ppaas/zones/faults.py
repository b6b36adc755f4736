"""Faults of the zones of a map, gathered so that all of them are reported at once."""

from ppaas.errors import InvalidZones, ZoneFault

MOST_REPORTED = 20
"""Largest number of faults that are reported."""

LONGEST = 380
"""Length of the text from which on further faults are only counted."""


class Faults:
    """Faults of zones."""

    def __init__(self) -> None:
        self._found: list[ZoneFault] = []
        self._texts: list[str] = []

    def add(self, zone: str, text: str, place: tuple[float, float] | None = None, whole: str | None = None) -> None:
        """Add a fault of a zone, at a place in the frame of the map [m].

        ``whole`` is the sentence of the error; "zone 'NAME': TEXT" if it is not given.
        """
        self._found.append(ZoneFault(zone, text, place))
        self._texts.append(whole or f"zone {zone!r:.80}: {text}")

    def check(self) -> None:
        """Raise ``InvalidZones`` if there are faults."""
        if not self._found:
            return
        text = self._texts[0]
        for number, more in enumerate(self._texts[1:], 1):
            if len(text) + len(more) > LONGEST:
                text += f"; and {len(self._texts) - number} more"
                break
            text += f"; {more}"
        raise InvalidZones(text, self._found[:MOST_REPORTED])


def place_text(place: tuple[float, float]) -> str:
    """Return a place as text [m]."""
    return f"({place[0]:.6g}, {place[1]:.6g})"
