"""Services of ``ppaas_msgs`` that watch a robot: what was observed of it, and recordings of its topics."""

from msgspec import field

from ppaas.messages.base.message import Empty, OwnMessage, ServiceType

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


class StartRecordingRequest(OwnMessage):
    """``ppaas_msgs/StartRecording`` request.

    Parameters
    ----------
    seconds : float
        Time after which the recording ends by itself [s].
    topics : list of str
        Globs of the topics to record; empty for the robot file's globs.
    """

    seconds: float
    topics: list[str] = field(default_factory=list)


class RecorderState(OwnMessage):
    """``ppaas_msgs/RecorderState``: response of all services of the recorder.

    Parameters
    ----------
    recording : str
        Id of the recording in progress; empty if there is none.
    left : float
        Time until it ends by itself [s].
    ring_minutes : float
        Length of the ring of the last minutes [min]; 0 if the robot has none.
    messages, lost : int
        Numbers of messages that were recorded, and that were dropped because the machine was too slow.
    problem : str
        Why nothing is recorded, or a recording ended early; empty if all is well.
    """

    recording: str = ""
    left: float = 0.0
    ring_minutes: float = 0.0
    messages: int = 0
    lost: int = 0
    problem: str = ""


StartRecording = ServiceType("ppaas_msgs/StartRecording", StartRecordingRequest, RecorderState)
StopRecording = ServiceType("ppaas_msgs/StopRecording", Empty, RecorderState)
GetRecorderState = ServiceType("ppaas_msgs/GetRecorderState", Empty, RecorderState)

SERVICES = (Observe, StartRecording, StopRecording, GetRecorderState)
