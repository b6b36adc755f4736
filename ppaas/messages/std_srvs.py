"""``std_srvs``: services without a payload."""

from ppaas.messages.message import Empty, Message, ServiceType


class TriggerResponse(Message):
    """Answer of ``std_srvs/Trigger``."""

    success: bool
    message: str = ""


EmptyService = ServiceType("std_srvs/Empty", Empty, Empty)
Trigger = ServiceType("std_srvs/Trigger", Empty, TriggerResponse)

SERVICES = (EmptyService, Trigger)
