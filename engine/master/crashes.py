"""Crash counts of places: delays before a restart, and detection of crash loops."""

from engine.master.places import Place

CRASH_LIMIT = 5
CRASH_WINDOW = 30.0
"""More than `CRASH_LIMIT` crashes within `CRASH_WINDOW` [s] are a crash loop: the place is closed."""

RESTART_DELAYS = (0.0, 0.25, 1.0, 2.0, 4.0)
"""Delay of the restart after the first, second, … crash within the window [s]. A store that is unreachable for a moment
is back before the place is closed."""


def note_crash(place: Place, now: float) -> float | None:
    """Count a crash; return the delay until the container is replaced [s], or None in a crash loop."""
    place.crashes = [t for t in place.crashes if now - t < CRASH_WINDOW] + [now]
    crashes = len(place.crashes)
    return RESTART_DELAYS[crashes - 1] if crashes <= CRASH_LIMIT else None
