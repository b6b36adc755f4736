"""Error of a lookup between two frames that no transform connects."""

from collections.abc import Sequence

from ppaas.errors import TransformError, listed

MOST_NAMED = 20
"""Largest number of known frames that an error names."""


def not_connected(target: str, source: str, known: Sequence[str]) -> TransformError:
    """Return the error of a lookup; it names the frames that are unknown, and those that are known."""
    more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
    names = f"{listed(known[:MOST_NAMED]) or 'none'}{more}"
    unknown = " and ".join(repr(frame) for frame in dict.fromkeys((target, source)) if frame not in known)
    if unknown:
        return TransformError(f"unknown frame {unknown}; known: {names}")
    return TransformError(f"{source!r} and {target!r} are not connected; known: {names}")
