"""Robots of 2013 without sockets, at places whose containers the test plays."""

import asyncio
import json
from dataclasses import dataclass, field
from typing import Any

import msgspec

from endpoints.rapyuta.executor import Executor
from endpoints.rapyuta.interfaces import EndpointTable
from endpoints.rapyuta.robot import Identity, RapyutaRobot
from endpoints.resources.services import Services
from endpoints.rosbridge import Attachment, AuthenticatedClient, ConnectRequest
from engine.links.carried_session import CarriedSession
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from engine.protocols.session_frames import SessionClient, SessionOptions
from engine.rights.access import Access
from ppaas.errors import NotFound, PPaaSError
from ppaas.messages import decode, encode, rosapi
from ppaas.nodes.parameter_server.tree import ParameterTree, read_value
from ppaas.wire.rapyuta.answers import AnswerFrames
from tests.support.endpoints.still_link import StillLink
from tests.support.endpoints.still_place import StillPlace
from tests.support.network.still_socket import BINARY, sent

NODES = ("map_server", "amcl", "move_base", "robot_state_publisher", "tf2_web_republisher")
"""Nodes of a clone on a map."""

OWN = {"amcl": {"max_particles": 2000, "min_particles": 100}, "DWAPlannerROS": {"max_vel_x": 0.5}}
"""Parameters of its nodes."""


class ClonePlace(StillPlace):
    """Place whose container answers calls: of parameters by a tree of them, others with the test's answers."""

    def __init__(self, parameters: dict[str, Any] | None = None) -> None:
        super().__init__()
        self.tree = ParameterTree({node: values | (parameters or {}).get(node, {}) for node, values in OWN.items()})
        self.answers: dict[str, bytes | PPaaSError] = {}
        self.called: list[tuple[str, Any]] = []
        names = (*NODES, *(name for name in parameters or {} if name not in OWN))
        self.nodes = {name: robot_link.NodeInfo(name, (), (), ()) for name in names}
        for name in ("set_param", "has_param", "delete_param"):
            kind = "".join(part.capitalize() for part in name.split("_"))
            self.services[f"rosapi/{name}"] = robot_link.ServiceInfo(f"rosapi/{name}", f"rosapi/{kind}")
        write = self.far.write

        def answering(frame: robot_link.ToContainer) -> None:
            write(frame)
            if isinstance(frame, robot_link.ServiceCall):
                asyncio.get_running_loop().call_soon(self._answer, frame)

        self.far.write = answering  # type: ignore[method-assign]

    def _answer(self, call: robot_link.ServiceCall) -> None:
        self.called.append((call.service, json.loads(call.payload)))
        try:
            answer = self._answer_to(call.service, call.payload)
        except PPaaSError as error:
            answer = error
        if isinstance(answer, PPaaSError):
            self.say(robot_link.ServiceAnswer(call.call, refusal=Refusal(answer.slug, str(answer))))
        else:
            self.say(robot_link.ServiceAnswer(call.call, answer))

    def _answer_to(self, service: str, payload: bytes) -> bytes | PPaaSError:
        match service:
            case "rosapi/set_param":
                request = decode(rosapi.SetParam.request, payload)
                self.tree.set(request.name, read_value(request.value))  # type: ignore[attr-defined]
                return b"{}"
            case "rosapi/delete_param":
                self.tree.delete(json.loads(payload)["name"])
                return b"{}"
            case "rosapi/has_param":
                return encode(rosapi.HasParamResponse(self.tree.has(json.loads(payload)["name"])))
        return self.answers.get(service) or NotFound("service", service)


@dataclass
class StillSessions:
    """Attaches clients to a place without sockets; ``refusals`` are raised first, one after the other."""

    place: StillPlace = field(default_factory=ClonePlace)
    refusals: list[PPaaSError] = field(default_factory=list)
    attached: list[Attachment] = field(default_factory=list)
    opened: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.link = StillLink(self.place)

    async def attach(self, caller: AuthenticatedClient, request: ConnectRequest, access: Access) -> Attachment:
        await asyncio.sleep(0)
        if self.refusals:
            raise self.refusals.pop(0)
        self.opened.append(request.robot)
        if self.link.still is not self.place:
            self.link = StillLink(self.place)
        client = SessionClient(caller.user, request.owner or caller.user, request.robot, request.role)
        session = CarriedSession(self.link, client, SessionOptions("error"), access)
        attachment = Attachment(session, self.link, request, caller)
        session.attach()
        self.attached.append(attachment)
        return attachment

    def detach(self, attachment: Attachment, *, for_good: bool) -> None:
        assert for_good
        attachment.detach(for_good=True)
        self.attached.remove(attachment)


class StillRobot:
    """Robot of 2013 without a socket."""

    def __init__(
        self, services: Services, sessions: StillSessions, table: EndpointTable, token: str, tag: str = "tb1"
    ) -> None:
        self.robot = RapyutaRobot(tag, Identity("ann", token))
        table.add(self.robot)
        self.executor = Executor(self.robot, table, services, sessions)  # type: ignore[arg-type]

    async def do(self, kind: str, **data: Any) -> list[dict[str, Any]]:
        """Execute a message; return what the robot receives."""
        await self.executor.execute({"type": kind, "data": data})
        return self.received()

    async def add(self, endpoint: str, tag: str, kind: str, cls: str, addr: str = "") -> list[dict[str, Any]]:
        """Add an interface."""
        interface = {"endpointTag": endpoint, "interfaceTag": tag, "interfaceType": kind, "className": cls}
        return await self.do("CN", addInterfaces=[interface | ({"addr": addr} if addr else {})])

    async def joined(self, tag: str, role: str, cls: str, addr: str, form: str = "Converter") -> None:
        """Add an interface of the robot and one of the container c1, and connect them."""
        other = {"Subscriber": "Publisher", "Publisher": "Subscriber"}
        other |= {"ServiceProvider": "ServiceClient", "ServiceClient": "ServiceProvider"}
        assert await self.add("c1", tag, f"{other[role]}Interface", cls, addr) == []
        assert await self.add(self.robot.tag, tag, f"{role}{form}", cls) == []
        found = await self.do("CX", connect=[{"tagA": f"{self.robot.tag}/{tag}", "tagB": f"c1/{tag}"}])
        assert {"type": "ST", "data": {"topic": "iu", "iTag": tag, "status": True}} in found, found

    async def send(self, tag: str, cls: str, message: Any, message_id: str = "m1") -> list[dict[str, Any]]:
        """Send a message; return what the robot receives at once."""
        return await self.do("DM", iTag=tag, type=cls, msgID=message_id, msg=message)

    def received(self) -> list[dict[str, Any]]:
        """Return the messages sent to the robot since the last call, with bytes in place of references."""
        blocks = [AnswerFrames.unpack(frame.encode(errors=BINARY)) for frame in sent(self.robot.outbox)]
        return [_with_parts(frames) for frames in blocks]


def _with_parts(frames: AnswerFrames) -> dict[str, Any]:
    parts = {part[:32].decode(): part[32:] for part in frames.parts}
    message: dict[str, Any] = msgspec.json.decode(frames.text)

    def placed(value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {
            key.removesuffix("*"): parts.pop(item) if key.endswith("*") else placed(item) for key, item in value.items()
        }

    found: dict[str, Any] = placed(message)
    assert not parts
    return found


def error_in(messages: list[dict[str, Any]]) -> str:
    """Return the text of the only message, which must be an error."""
    [message] = messages
    assert message["type"] == "ER", message
    text: str = message["data"]
    return text
