"""``std_srvs``: standard service types."""

from ppaas.messages.base.message import Empty, Message, ServiceType


class TriggerResponse(Message):
    """``std_srvs/Trigger`` response."""

    success: bool
    message: str = ""


class SetBoolRequest(Message):
    """``std_srvs/SetBool`` request."""

    data: bool = False


class SetBoolResponse(Message):
    """``std_srvs/SetBool`` response."""

    success: bool
    message: str = ""


EmptyService = ServiceType("std_srvs/Empty", Empty, Empty)
Trigger = ServiceType("std_srvs/Trigger", Empty, TriggerResponse)
SetBool = ServiceType("std_srvs/SetBool", SetBoolRequest, SetBoolResponse)

SERVICES = (EmptyService, Trigger, SetBool)
