"""Stands still for a while: what is in the way may go away by itself (``nav2_behaviors/wait.hpp``)."""

from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Recovery, RecoveryRequest


class WaitParameters(Parameters, frozen=True):
    """Parameters of ``wait``, with the name and value of Nav2's behaviour tree.

    Parameters
    ----------
    wait_duration : float
        How long [s].
    """

    wait_duration: NotNegative = 5.0


class WaitRecovery(Recovery):
    """Stands still for ``wait_duration``.

    Parameters
    ----------
    **parameters
        The fields of `WaitParameters`.
    """

    name: ClassVar[str] = "wait"
    purpose: ClassVar[str] = "Stands still for wait_duration: what is in the way may go away."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(WaitParameters, self.name, parameters)
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Take note of the time."""
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Stand, until the time is over."""
        return None if request.now - self._began >= self.parameters.wait_duration else Velocity()
