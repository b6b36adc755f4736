"""The deadline and the cancel checker of one request, asked between slices of work."""

import math

from ppaas.errors import InvalidInput, PlanCancelled, PlanTimeout
from ppaas.planners.base import PlanRequest


def proceed() -> None:
    """Be the check that lets all work go on."""


class Watch:
    """Watches one request from the moment it is made.

    Parameters
    ----------
    request : PlanRequest
        Whose clock, timeout and cancel checker to use.

    Raises
    ------
    InvalidInput
        A timeout or a tolerance that is negative or NaN, a pose that is not finite, or no thread at all.
    """

    def __init__(self, request: PlanRequest) -> None:
        _check_request(request)
        self._request = request
        self._began = request.clock()

    def seconds(self) -> float:
        """Return the seconds since it was made."""
        return self._request.clock() - self._began

    def check(self) -> None:
        """Let the work go on, or end it.

        Raises
        ------
        PlanCancelled
            The cancel checker said so.
        PlanTimeout
            The time allowed is used up.
        """
        if self._request.cancelled():
            raise PlanCancelled("planning was cancelled; send the request again if a path is still wanted")
        if self.seconds() >= self._request.timeout:
            raise PlanTimeout(
                f"no path within {self._request.timeout} s; allow more time or plan to a goal that is nearer"
            )


def _check_request(request: PlanRequest) -> None:
    for what, pose in (("start", request.start), ("goal", request.goal)):
        if not pose.is_finite():
            raise InvalidInput(f"the {what} must be finite x, y [m] and theta [rad], not {tuple(pose)}")
    for what, value, unit in (("tolerance", request.tolerance, "metres"), ("timeout", request.timeout, "seconds")):
        if math.isnan(value) or value < 0.0:
            raise InvalidInput(f"the {what} must be zero or more {unit}, not {value}")
    if request.threads < 1:
        raise InvalidInput(f"planning takes at least one thread, not {request.threads}")
