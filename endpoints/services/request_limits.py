"""Limits of what a request may ask for."""

from dataclasses import dataclass

MIB = 1 << 20


@dataclass(frozen=True, slots=True)
class RequestLimits:
    """Limits of the REST service.

    Parameters
    ----------
    max_body : int
        Largest body of a request, uploads apart [bytes].
    max_upload : int
        Largest upload of a map, its files and the form around them together [bytes].
    max_body_seconds, max_upload_seconds : float
        Time in which the one or the other must have come [s].
    max_plan_seconds : float
        Longest time that a planner may be given [s].
    """

    max_body: int = 1 * MIB
    max_upload: int = 256 * MIB
    max_body_seconds: float = 30.0
    max_upload_seconds: float = 300.0
    max_plan_seconds: float = 60.0
