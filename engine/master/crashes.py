"""How often a place lost its container lately, and what follows from that."""

from engine.master.places import Place

CRASH_LIMIT = 5
CRASH_WINDOW = 30.0
"""More crashes than the limit within the window [s] are a crash loop, and the place is closed."""

RESTART_DELAYS = (0.0, 0.25, 1.0, 2.0, 4.0)
"""Seconds before what replaces a container starts, after its first, second … crash within the window: what is away for
a moment, as a store, is back before the place is given up."""


def note_crash(place: Place, now: float) -> float | None:
    """Note a crash; return the seconds after which the container is replaced, or None where it crashes in a loop."""
    place.crashes = [t for t in place.crashes if now - t < CRASH_WINDOW] + [now]
    crashes = len(place.crashes)
    return RESTART_DELAYS[crashes - 1] if crashes <= CRASH_LIMIT else None
