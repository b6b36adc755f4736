"""Workcells of Open-RMF: dispensers load robots that hold for them, ingestors unload them.

A request is repeated until its workcell answers, as Open-RMF does. Its id follows from the task, so a bridge that is
started again repeats the request of the one before.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

Kind = Literal["dispenser", "ingestor"]
KINDS: Final[tuple[Kind, ...]] = ("dispenser", "ingestor")

ACKNOWLEDGED, SUCCESS, FAILED = 0, 1, 2
"""Status of a result."""

REPEAT = 2.0
"""Time after which a request without an answer is repeated [s]."""

AGAIN = 30.0
"""Time after which a workcell that failed, or acknowledged and said no more, is asked again [s]."""


@dataclass(slots=True)
class _Request:
    """Request of a task to a workcell."""

    kind: Kind
    map: str
    task: str
    target: str
    items: Mapping[str, int]
    due: float
    is_done: bool = False


class Workcells:
    """Requests for the robots that hold for workcells.

    Parameters
    ----------
    transporter : str
        Type of the robots, in requests.
    """

    def __init__(self, transporter: str) -> None:
        self._transporter = transporter
        self._requests: dict[str, _Request] = {}

    def see(self, tasks: Iterable[Mapping[str, Any]], now: float) -> list[tuple[Kind, dict[str, Any]]]:
        """Note all open tasks, as REST has them, and return the requests that are due, as messages."""
        waiting = {}
        for task in tasks:
            hold = _hold_of(task)
            kind: Kind | None = next((kind for kind in KINDS if hold.get(kind)), None)
            if kind is not None:
                guid = f"{task['id']}-{task['visited']}-{round(1000.0 * task['holding'])}"
                made = _Request(kind, task["map"], task["id"], hold[kind], hold.get("items", {}), now)
                waiting[guid] = self._requests.get(guid, made)
        self._requests = waiting
        due = [(guid, request) for guid, request in waiting.items() if now >= request.due and not request.is_done]
        for _, request in due:
            request.due = now + REPEAT
        return [(request.kind, self._message(guid, request, now)) for guid, request in due]

    def take(self, kind: Kind, result: Mapping[str, Any], now: float) -> tuple[str, str] | str:
        """Take a result; return the map and the task to confirm, or what a person should know: often nothing."""
        request = self._requests.get(result["request_guid"])
        if request is None or request.kind != kind or request.is_done or result["source_guid"] != request.target:
            return ""
        if result["status"] == SUCCESS:
            request.is_done = True
            return request.map, request.task
        request.due = now + AGAIN
        if result["status"] == ACKNOWLEDGED:
            return ""
        return f"{kind} {request.target!r} failed task {request.task}: it is asked again in {AGAIN:g} s"

    def confirm_failed(self, task: str) -> None:
        """Ask again, since the confirmation of a task did not arrive."""
        for request in self._requests.values():
            if request.task == task:
                request.is_done = False

    def _message(self, guid: str, request: _Request, now: float) -> dict[str, Any]:
        items = [{"type_guid": name, "quantity": number} for name, number in request.items.items()]
        return {
            "time": {"sec": int(now), "nanosec": int(now % 1.0 * 1e9)},
            "request_guid": guid,
            "target_guid": request.target,
            "transporter_type": self._transporter,
            "items": items,
        }


def _hold_of(task: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return for what the robot of a task holds now; nothing if it does not."""
    if not task["needs_confirmation"]:
        return {}
    hold: Mapping[str, Any] | None = task["holds"][(task["visited"] - 1) % len(task["places"])]
    return hold or {}
