"""Deadline and cancellation of one request, checked between slices of work."""

import math

from ppaas.compile_time import compile_stopwatch
from ppaas.errors import InvalidInput, PlanCancelled, PlanTimeout
from ppaas.planners.base import PlanRequest


def proceed() -> None:
    """Do nothing: the default check, which never ends the work."""


class Watch:
    """Watch over the time limit and the cancellation of one request, from its construction on.

    Several threads may check it. Time that the calling thread spends on compiling kernels meanwhile does not count.

    Parameters
    ----------
    request : PlanRequest
        Its clock, timeout and cancel checker are used.

    Raises
    ------
    InvalidInput
        A timeout or a tolerance is negative or NaN, a pose is not finite, or the number of threads is below 1.
    """

    def __init__(self, request: PlanRequest) -> None:
        _check_request(request)
        self._request = request
        self._compiled = compile_stopwatch()
        self._began = request.clock()

    def seconds(self) -> float:
        """Return the time since construction, without the time to compile kernels [s]."""
        return self._request.clock() - self._began - self._compiled()

    def check(self) -> None:
        """Raise if the work must end.

        Raises
        ------
        PlanCancelled
            The request was cancelled.
        PlanTimeout
            The time limit has passed.
        """
        if self._request.cancelled():
            raise PlanCancelled("planning was cancelled; send the request again if a path is still wanted")
        if self.seconds() >= self._request.timeout:
            raise PlanTimeout(
                f"no path found within {self._request.timeout} s; allow more time or choose a nearer goal"
            )


def _check_request(request: PlanRequest) -> None:
    for what, pose in (("start", request.start), ("goal", request.goal)):
        if not pose.is_finite():
            raise InvalidInput(f"the {what} must be finite x, y [m] and theta [rad], not {tuple(pose)}")
    for what, value, unit in (("tolerance", request.tolerance, "metres"), ("timeout", request.timeout, "seconds")):
        if math.isnan(value) or value < 0.0:
            raise InvalidInput(f"the {what} must be at least 0 {unit}, not {value}")
    if request.threads < 1:
        raise InvalidInput(f"threads must be at least 1, not {request.threads}")
