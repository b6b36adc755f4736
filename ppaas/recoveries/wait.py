"""Recovery ``wait``: stands still for a time, in case the obstacle moves away (``nav2_behaviors/wait.hpp``)."""

from typing import Any, ClassVar

from ppaas.controllers.base import Velocity
from ppaas.parameters import Parameters, read_parameters
from ppaas.recoveries.base import NotNegative, Recovery, RecoveryRequest


class WaitParameters(Parameters, frozen=True):
    """Parameters of ``wait``, with the name and value of Nav2's behaviour tree.

    Parameters
    ----------
    wait_duration : float
        Time to wait [s].
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
    purpose: ClassVar[str] = "Stands still for wait_duration, in case the obstacle moves away."

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(WaitParameters, self.name, parameters)
        self._began = 0.0

    def start(self, request: RecoveryRequest) -> None:
        """Record the time."""
        self._began = request.now

    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Stand still until the time has passed."""
        return None if request.now - self._began >= self.parameters.wait_duration else Velocity()
