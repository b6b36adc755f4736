"""``std_srvs``: services that need no types of their own."""

from ppaas.messages.message import Empty, Message, ServiceType


class TriggerResponse(Message):
    """Answer of ``std_srvs/Trigger``."""

    success: bool
    message: str = ""


class SetBoolRequest(Message):
    """Request of ``std_srvs/SetBool``."""

    data: bool = False


class SetBoolResponse(Message):
    """Answer of ``std_srvs/SetBool``."""

    success: bool
    message: str = ""


EmptyService = ServiceType("std_srvs/Empty", Empty, Empty)
Trigger = ServiceType("std_srvs/Trigger", Empty, TriggerResponse)
SetBool = ServiceType("std_srvs/SetBool", SetBoolRequest, SetBoolResponse)

SERVICES = (EmptyService, Trigger, SetBool)
