"""Words on what was mended or may be wrong in zones that are taken: one sentence for all zones that it concerns."""

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
