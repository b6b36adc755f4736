"""Goals that a place of a robot has received, and their ends."""

from ppaas.messages.actionlib_msgs import Status
from tests.support.endpoints.still_place import StillRobot, delivered


class GoalsOf:
    """Reads what is delivered to a place once, and keeps the ids of its goals and cancellations."""

    def __init__(self, place: StillRobot) -> None:
        self._place = place
        self._sent: list[str] = []
        self._cancelled: list[str] = []

    @property
    def sent(self) -> list[str]:
        """Ids of the goals that were sent."""
        self._read()
        return self._sent

    @property
    def cancelled(self) -> list[str]:
        """Ids of the goals that were cancelled; empty for all."""
        self._read()
        return self._cancelled

    def end(self, status: Status, text: str = "") -> None:
        """End every goal that was sent, as Move Base."""
        for goal in self.sent:
            ended = {"goal_id": {"id": goal}, "status": status, "text": text}
            self._place.publish_json("move_base/result", {"header": {"frame_id": ""}, "status": ended})

    def _read(self) -> None:
        for topic, message in delivered(self._place):
            if topic == "move_base/goal":
                self._sent.append(message["goal_id"]["id"])
            elif topic == "move_base/cancel":
                self._cancelled.append(message["id"])
