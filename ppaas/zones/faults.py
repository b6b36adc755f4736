"""Faults of the zones of a map, gathered so that all are reported at once, and notes on what was mended."""

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


# -- notes: one sentence for all zones that it concerns ----------------------------------------------------------------

NAMED = 3
"""Number of zones that a sentence names; the others are counted."""


class Notes:
    """Sentences on zones, in the order in which they came up."""

    def __init__(self) -> None:
        self._zones: dict[str, list[str]] = {}

    def add(self, sentence: str, zone: str | None = None) -> None:
        """Add a sentence on a zone, or on all of them if none is named."""
        zones = self._zones.setdefault(sentence, [])
        if zone is not None and zone not in zones:
            zones.append(zone)

    def texts(self) -> list[str]:
        """Return the sentences, each with the zones that it concerns."""
        return [f"{_named(zones)}: {sentence}" if zones else sentence for sentence, zones in self._zones.items()]


def _named(zones: list[str]) -> str:
    names = ", ".join(repr(zone) for zone in zones[:NAMED])
    more = f" and {len(zones) - NAMED} more" if len(zones) > NAMED else ""
    return f"{'zone' if len(zones) == 1 else 'zones'} {names}{more}"
