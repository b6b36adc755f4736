"""``ppaas_msgs/Observe``: the service that returns what was observed of a robot."""

from ppaas.messages.base.message import OwnMessage, ServiceType

PACKAGE = "ppaas_msgs"
"""ROS package of the types here."""


class ObserveRequest(OwnMessage):
    """``ppaas_msgs/Observe`` request.

    Parameters
    ----------
    seconds : float
        Time for which the robot must have been watched before the answer, at most 8 [s].
    """

    seconds: float = 3.0


class ObserveResponse(OwnMessage):
    """``ppaas_msgs/Observe`` response.

    Parameters
    ----------
    observations : str
        `ppaas.diagnosis.observations.facts.Observations` as JSON.
    """

    observations: str


Observe = ServiceType("ppaas_msgs/Observe", ObserveRequest, ObserveResponse)

SERVICES = (Observe,)
