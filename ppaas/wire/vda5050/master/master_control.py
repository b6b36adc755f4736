"""Master control of one AGV: takes paths and what the AGV reports, returns instructions.

Each event ends in `_advance`, which compares the path that is wanted with the order that the AGV has::

    no order ──path──► sent ──the AGV takes it──► driving ──at the last node──► ended
                         ▲                          │  │
                         └──an update, to release more│  │ another path, a cancel, or a contradiction
                                                      │  ▼
                                                      cancelling ──no order is left──► no order

So a bridge that restarts, a broker that loses messages and an AGV that does something else all end in the same places.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

from ppaas.messages.nav2_motions import FollowPathError
from ppaas.wire.vda5050.fields import Position
from ppaas.wire.vda5050.master.instructions import (
    Complaint,
    Instruction,
    PathEnded,
    Progress,
    SendActions,
    SendOrder,
    errors_in_words,
    fatal_error,
    instant_action,
    rejection,
    standing,
)
from ppaas.wire.vda5050.master.order_plan import OrderPlan, PlannedNode, index_of, is_ours, key_of, route_nodes
from ppaas.wire.vda5050.master.route import Route
from ppaas.wire.vda5050.master.settings import TRIES, Settings
from ppaas.wire.vda5050.states import ENDED, ConnectionState, NodeState, State

# -- adoption of an order that an AGV drives already, after a restart of the bridge ------------------------------------


def is_active(state: State) -> bool:
    """Return whether an AGV has an order that it has not finished."""
    return bool(state.order_id) and bool(state.node_states or state.edge_states)


def is_of_this_bridge(state: State) -> bool:
    """Return whether the order of an AGV looks like one of this bridge."""
    return is_ours(state.order_id, [node.node_id for node in state.node_states])


def adopted(path: str, route: Route, map_id: str, state: State) -> OrderPlan | None:
    """Return the order of an AGV that leads along a path; None if its order leads elsewhere.

    Parameters
    ----------
    path : str
        Id of the path.
    route : Route
        Route of that path, the same as before the restart.
    map_id : str
        Map, as the AGV names it.
    state : State
        Newest state of the AGV.
    """
    key = key_of(path)
    told = [(node.node_id, node.sequence_id) for node in state.node_states]
    last = state.last_node_id, state.last_node_sequence_id
    known = [(index, sequence) for name, sequence in (*told, last) if (index := index_of(key, name)) is not None]
    if not state.order_id or not known:
        return None
    index, sequence = known[0]
    first = sequence - 2 * index
    if first < 0 or first % 2:
        return None
    prefix = [_planned(node) for node in state.node_states if node.sequence_id <= first]
    nodes = prefix + route_nodes(key, route, first)[1:] if prefix else route_nodes(key, route, first)
    plan = OrderPlan(state.order_id, path, route, map_id, nodes, before=last)
    if not _agrees(plan, told):
        return None
    _take_state(plan, state)
    return plan


def _take_state(plan: OrderPlan, state: State) -> None:
    last = plan.node(state.last_node_sequence_id)
    plan.reached = last.sequence if last is not None and last.id == state.last_node_id else None
    released = [node.sequence_id for node in state.node_states if node.released]
    plan.released = max(released, default=state.last_node_sequence_id)
    plan.update_id, plan.is_sent, plan.accepted = state.order_update_id, True, True


def _planned(node: NodeState) -> PlannedNode:
    position = node.node_position
    return PlannedNode(node.node_id, node.sequence_id, None if position is None else (position.x, position.y))


def _agrees(plan: OrderPlan, told: list[tuple[str, int]]) -> bool:
    """Return whether the sequence ids have no gap, and all nodes that the AGV names are in the order."""
    if any(b.sequence - a.sequence != 2 for a, b in pairwise(plan.nodes)):
        return False
    return all((node := plan.node(sequence)) is not None and node.id == name for name, sequence in told)


# -- cancellation of an order by the instant action ``cancelOrder`` ----------------------------------------------------

SILENT = 3.0
"""Time after which an AGV without an order has cancelled it, although it says nothing of the action [s]."""


class Cancelling:
    """Cancellation in progress, if there is one.

    Attributes
    ----------
    since : float
        Time of the last message [s].
    """

    def __init__(self) -> None:
        self.since = 0.0
        self._action = ""
        self._tries = 0

    @property
    def active(self) -> bool:
        """True while an order is to be cancelled."""
        return bool(self._action)

    def begin(self, now: float) -> SendActions:
        """Return the message that cancels the order."""
        self._tries = 0
        return self._send(now)

    def again(self, now: float) -> SendActions | None:
        """Return the message once more; None if it was sent often enough, which ends the cancellation."""
        if self._tries >= TRIES:
            self._action = ""
            return None
        return self._send(now)

    def is_done(self, state: State, now: float, *, idle: bool) -> bool:
        """Return whether the AGV has cancelled its order, or has none; this ends the cancellation."""
        states = (*state.instant_action_states, *state.action_states)
        status = next((one.action_status for one in states if one.action_id == self._action), None)
        answered = status in ENDED or (status is None and now - self.since > SILENT)
        done = idle and not state.driving and answered
        if done:
            self._action = ""
        return done

    def _send(self, now: float) -> SendActions:
        self._tries += 1
        self.since = now
        message = instant_action("cancelOrder", now)
        self._action = message.actions[0].action_id
        return SendActions(message)


# -- contradictions between an order and the state that an AGV reports, in words ---------------------------------------

MARGIN = 1.5
"""Factor on the top speed up to which a distance between two nodes is believed."""

SLACK = 2.0
"""Distance that is always believed [m]: clocks and networks are not exact."""


def contradiction(plan: OrderPlan, state: State, now: float, settings: Settings) -> str:
    """Return the first contradiction of a state to the order that it names; empty if there is none.

    Parameters
    ----------
    plan : OrderPlan
        Order as it was sent.
    state : State
        State with the order's id.
    now : float
        Time of the state [s].
    settings : Settings
    """
    return _numbers(plan, state) or _nodes(plan, state) or _last_node(plan, state, now, settings)


def _numbers(plan: OrderPlan, state: State) -> str:
    if state.order_update_id <= plan.update_id:
        return ""
    return f"it names update {state.order_update_id} of its order, whose newest is {plan.update_id}"


def _nodes(plan: OrderPlan, state: State) -> str:
    for told in state.node_states:
        node = plan.node(told.sequence_id)
        if node is None or node.id != told.node_id:
            return f"it is to reach node {told.node_id[:60]!r} ({told.sequence_id}), which its order does not have"
        if told.released and node.sequence > plan.released:
            return f"it counts node {told.node_id[:60]!r} ({told.sequence_id}) as released, which it is not"
    return ""


def _last_node(plan: OrderPlan, state: State, now: float, settings: Settings) -> str:
    name, sequence = state.last_node_id, state.last_node_sequence_id
    if plan.reached is None and (not name or (name, sequence) == plan.before):
        return ""
    node, words = plan.node(sequence), f"node {name[:60]!r} ({sequence})"
    if node is None or node.id != name:
        return f"the last node that it reached is {words}, which its order does not have"
    if plan.reached is not None and sequence < plan.reached:
        return f"it went back to {words} after it had reached {plan.reached}"
    if sequence > plan.released:
        return f"it reached {words}, beyond the end of its base ({plan.released})"
    seconds = now - plan.reached_at
    far = plan.between(plan.position(plan.reached), plan.position(sequence))
    if far > MARGIN * settings.top_speed * seconds + SLACK:
        return f"it jumped {far:.1f} m along its route to {words} in {seconds:.1f} s"
    return _far_from_node(node.place, state, words, settings) if node is plan.last else ""


def _far_from_node(place: tuple[float, float] | None, state: State, words: str, settings: Settings) -> str:
    """Return a contradiction of an AGV that says to be at its last node, with no node left, and is elsewhere."""
    position = state.mobile_robot_position
    if place is None or position is None or not position.localized or state.node_states:
        return ""
    far = math.hypot(position.x - place[0], position.y - place[1])
    limit = settings.end_deviation + 0.5
    return f"it says that it reached {words}, but is {far:.2f} m away from it" if far > limit else ""


def distance_off(plan: OrderPlan, state: State) -> float:
    """Return the distance of an AGV from the edge that it drives on, by its own position [m]; 0 if that is unknown.

    Edges next to it count as well, since the node between may be reached any moment.
    """
    position = state.mobile_robot_position
    if position is None or not position.localized or position.map_id != plan.map_id:
        return 0.0
    at = plan.position(plan.reached)
    places = [node.place for node in plan.nodes[max(at - 1, 0) : at + 3] if node.place is not None]
    return min((_apart(begin, end, position) for begin, end in pairwise(places)), default=0.0)


def _apart(begin: tuple[float, float], end: tuple[float, float], position: Position) -> float:
    """Return the distance of a position from an edge [m]: for one, numpy takes five times as long."""
    along_x, along_y = end[0] - begin[0], end[1] - begin[1]
    x, y = position.x - begin[0], position.y - begin[1]
    part = min(max((x * along_x + y * along_y) / max(along_x**2 + along_y**2, 1e-12), 0.0), 1.0)
    return math.hypot(x - part * along_x, y - part * along_y)


# -- the master control: paths and reports of an AGV in, instructions out ----------------------------------------------

PROGRESS_PERIOD = 1.0
"""Period of progress while nothing changes [s]."""

LEFTOVER = 3.0
"""Time after a session with the cloud has begun within which it sends the path again, if there is one [s]."""

OFF_STATES = 2
"""Number of states in a row by which an AGV has left its route."""

NEAR = 0.3
"""Distance up to which two routes are one [m]."""


@dataclass(frozen=True, slots=True)
class AgvPath:
    """Path that the AGV is to follow: its id and its route."""

    id: str
    route: Route


class MasterControl:
    """Leads one AGV along paths.

    Parameters
    ----------
    settings : Settings

    Attributes
    ----------
    state : State or None
        Newest state of the AGV.
    connection : ConnectionState or None
        Newest state of its connection.
    left_out : str
        Why the AGV's newest states are left out, or cannot be used; empty if they are used. The owner sets it.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.state: State | None = None
        self.connection: ConnectionState | None = None
        self.left_out = ""
        self._is_renewed = False
        self._wanted: AgvPath | None = None
        self._order: OrderPlan | None = None
        self._cancelling = Cancelling()
        self._sent_at = 0.0
        self._confirm_by, self._knows_path = math.inf, False
        self._tries = self._off = 0
        self._broken_at: float | None = None
        self._stale_at: float | None = None
        self._told_at = -math.inf
        self._out: list[Instruction] = []

    @property
    def path(self) -> str:
        """Id of the path that is followed; empty if there is none."""
        return self._wanted.id if self._wanted else ""

    @property
    def order(self) -> OrderPlan | None:
        """The order that the AGV has from this master control."""
        return self._order

    @property
    def stale(self) -> str:
        """Why it is not known where the AGV is and what it does; no order begins or grows then. Empty if it is."""
        if self.connection != "ONLINE":
            return f"the AGV is {self.connection or 'not connected'}"
        if self.left_out:
            return self.left_out
        return "" if self._is_renewed else "the AGV has sent no state since its connection began"

    # -- events --------------------------------------------------------------------------------------------------------

    def follow(self, path: AgvPath, now: float) -> list[Instruction]:
        """Take a path in place of the one before; one with the same id is the same path, sent again."""
        self._out = []
        self._confirm_by, self._knows_path = math.inf, True
        if path.id != self.path:
            self._wanted = path
            self._advance(now)
        return self._out

    def ask_again(self, now: float) -> None:
        """Expect the path again: a session with the cloud has begun, whose clone may be another one without a goal."""
        self._confirm_by, self._knows_path = now + LEFTOVER, False

    def cancel(self, path: str, now: float) -> list[Instruction]:
        """Take the end of a path; of any path if the id is empty."""
        self._out = []
        if self._wanted is not None and path in ("", self._wanted.id):
            self._wanted = None
            self._advance(now)
        return self._out

    def take_state(self, state: State, now: float) -> list[Instruction]:
        """Take a state of the AGV."""
        self._out = []
        self.state, self._is_renewed = state, self.connection == "ONLINE"
        if self._order is None or self._cancelling.active:
            pass  # what it says of an order that is to be cancelled does not matter
        elif state.order_id == self._order.order_id:
            self._take_progress(self._order, state, now)
        else:
            self._take_other_order(self._order, state)
        self._advance(now)
        self._tell(now)
        return self._out

    def take_connection(self, connection: ConnectionState, now: float) -> list[Instruction]:
        """Take the state of the AGV's connection."""
        self._out = []
        self.connection = connection
        self._is_renewed = self._is_renewed and connection == "ONLINE"
        self._broken_at = None if connection == "ONLINE" else self._broken_at if self._broken_at is not None else now
        if connection in ("OFFLINE", "HIBERNATING"):
            self._fail(FollowPathError.FAILED_TO_MAKE_PROGRESS, f"the AGV is {connection}")
            self._order = None
        self._advance(now)
        return self._out

    def tick(self, now: float) -> list[Instruction]:
        """Advance the time: messages are sent again, patience runs out, progress is reported."""
        self._out = []
        if self._broken_at is not None and now - self._broken_at > self.settings.offline_patience:
            broken = f"the connection of the AGV has been broken for {now - self._broken_at:.0f} s"
            self._fail(FollowPathError.FAILED_TO_MAKE_PROGRESS, broken)
        is_stale = self.connection == "ONLINE" and bool(self.stale)
        self._stale_at = None if not is_stale else now if self._stale_at is None else self._stale_at
        if self._stale_at is not None and now - self._stale_at > self.settings.offline_patience:
            self._fail(FollowPathError.FAILED_TO_MAKE_PROGRESS, f"for {now - self._stale_at:.0f} s: {self.stale}")
        if now > self._confirm_by:
            self._confirm_by, self._knows_path, self._wanted = math.inf, True, None
        self._advance(now)
        if now - self._told_at >= PROGRESS_PERIOD:
            self._tell(now)
        return self._out

    # -- what the AGV says of its order --------------------------------------------------------------------------------

    def _take_progress(self, order: OrderPlan, state: State, now: float) -> None:
        if state.order_update_id == order.update_id:
            order.accepted = True
        wrong = contradiction(order, state, now, self.settings)
        if wrong:
            self._contradict(wrong)
            return
        last = order.node(state.last_node_sequence_id)
        if last is not None and last.id == state.last_node_id and last.sequence != order.reached:
            order.reached, order.reached_at = last.sequence, now
        off = distance_off(order, state)
        self._off = self._off + 1 if off > self.settings.off_route else 0
        if self._off >= OFF_STATES:
            self._contradict(f"it is {off:.1f} m off its route")
        elif error := fatal_error(state) or ("" if order.accepted else rejection(state, order.order_id)):
            self._fail(FollowPathError.FAILED_TO_MAKE_PROGRESS, f"the AGV reports {error}")
        elif order.accepted and not is_active(state) and not state.driving:
            self._end_of_order(order, state)

    def _end_of_order(self, order: OrderPlan, state: State) -> None:
        """Take a state without nodes: the order is finished, or the AGV has dropped it."""
        if order.is_finished:
            self._succeed(order)
            return
        why = rejection(state, order.order_id) or standing(state)
        at = order.position(order.reached)
        self._fail(
            FollowPathError.FAILED_TO_MAKE_PROGRESS,
            f"the AGV dropped its order at node {at} of {len(order.nodes) - 1}{': ' if why else ''}{why}",
        )
        self._order = None

    def _take_other_order(self, order: OrderPlan, state: State) -> None:
        """Take a state that names another order: that before this one, or one of somebody else."""
        if order.accepted:
            self._order = None
            self._contradict(f"it names order {state.order_id[:60]!r} in place of its own, {order.order_id!r}")
        elif error := rejection(state, order.order_id):
            self._order = None
            self._fail(FollowPathError.INVALID_PATH, f"the AGV rejects the order: {error}")

    def _succeed(self, order: OrderPlan) -> None:
        if self._wanted is not None and self._wanted.id == order.path:
            self._out.append(PathEnded(self._wanted.id, FollowPathError.NONE))
            self._wanted = None
        self._order = None

    def _contradict(self, text: str) -> None:
        self._off = 0
        self._out.append(Complaint(text))
        self._fail(FollowPathError.FAILED_TO_MAKE_PROGRESS, f"the AGV contradicts its order: {text}")

    def _fail(self, code: FollowPathError, reason: str) -> None:
        if self._wanted is not None:
            self._out.append(PathEnded(self._wanted.id, code, reason))
            self._wanted = None

    # -- from the wanted path to orders --------------------------------------------------------------------------------

    def _advance(self, now: float) -> None:
        state = self.state
        if state is None or self.connection != "ONLINE":
            return
        if self._cancelling.active:
            self._go_on_cancelling(state, now)
        elif self._order is not None and self._wanted is None:
            self._start_cancelling(now)
        elif self.stale:
            return
        elif self._order is None:
            self._begin(state, now)
        elif not self._order.accepted:
            self._wait_for_acceptance(self._order, now)
        elif self._wanted is not None and self._wanted.id != self._order.path:
            self._switch(self._order, self._wanted, state, now)
        elif self._order.needs_release(self.settings):
            self._send(self._order, now)

    def _begin(self, state: State, now: float) -> None:
        """Start with an AGV that has no order of this master control, as far as it is known."""
        wanted = self._wanted
        if wanted is None:
            if is_active(state) and is_of_this_bridge(state) and self._knows_path:
                self._start_cancelling(now)
            return
        position = state.mobile_robot_position
        known = adopted(wanted.id, wanted.route, position.map_id if position else "", state)
        if known is not None:
            self._order = known
            if not is_active(state) and not state.driving:
                self._end_of_order(known, state)
        elif is_active(state):
            if is_of_this_bridge(state):
                self._start_cancelling(now)
            else:
                self._fail(FollowPathError.UNKNOWN, f"the AGV drives order {state.order_id[:60]!r} of somebody else")
        elif position is not None and position.localized and not standing(state):
            self._start(wanted, state, now)

    def _start(self, wanted: AgvPath, state: State, now: float) -> None:
        position = state.mobile_robot_position
        assert position is not None
        route = wanted.route.after(position.x, position.y, self.settings.start_distance)
        if route is None:
            limit = self.settings.start_distance
            self._fail(FollowPathError.INVALID_PATH, f"the AGV is more than {limit:g} m away from its path")
            return
        before = state.last_node_id, state.last_node_sequence_id
        self._order, self._off = OrderPlan.of(wanted.id, route, position.map_id, before), 0
        self._order.reached_at = now
        self._send(self._order, now)

    def _send(self, order: OrderPlan, now: float) -> None:
        self._sent_at, self._tries = now, 1
        self._out.append(SendOrder(order.message(self.settings)))

    def _wait_for_acceptance(self, order: OrderPlan, now: float) -> None:
        if now - self._sent_at < self.settings.patience or order.newest is None:
            return
        if self._tries >= TRIES:
            errors = errors_in_words(self.state) if self.state is not None else ""
            text = f"the AGV has not taken its order, sent {TRIES} times{': ' if errors else ''}{errors}"
            self._fail(FollowPathError.PATIENCE_EXCEEDED, text)
            self._start_cancelling(now)
            return
        self._tries += 1
        self._sent_at = now
        self._out.append(SendOrder(order.newest))

    def _switch(self, order: OrderPlan, wanted: AgvPath, state: State, now: float) -> None:
        """Follow another path: by the order that leads there already, by an update of it, or by another order."""
        base_end = order.node(order.released)
        position = state.mobile_robot_position
        if base_end is None or base_end.place is None or position is None:
            self._start_cancelling(now)
            return
        rest = order.route.after(position.x, position.y, self.settings.off_route)
        if rest is not None and rest.is_near(wanted.route, NEAR):
            order.path = wanted.id
            return
        beyond = wanted.route.after(*base_end.place, NEAR)
        if beyond is None or rest is None or not _begins_with(wanted.route, rest, base_end.place):
            self._start_cancelling(now)
            return
        order.lead_on(wanted.id, wanted.route, beyond)
        self._send(order, now)

    # -- cancellation --------------------------------------------------------------------------------------------------

    def _start_cancelling(self, now: float) -> None:
        order, state = self._order, self.state
        assert state is not None
        if order is not None and order.accepted and not is_active(state) and not state.driving:
            self._order = None
            self._advance(now)
            return
        self._out.append(self._cancelling.begin(now))

    def _go_on_cancelling(self, state: State, now: float) -> None:
        if self._cancelling.is_done(state, now, idle=not is_active(state)):
            self._order = None
            self._advance(now)
        elif now - self._cancelling.since > self.settings.patience:
            again = self._cancelling.again(now)
            if again is not None:
                self._out.append(again)
                return
            self._out.append(Complaint(f"it does not cancel order {state.order_id[:60]!r}"))
            self._fail(FollowPathError.PATIENCE_EXCEEDED, "the AGV does not cancel the order that it has")
            self._order = None

    # -- progress ------------------------------------------------------------------------------------------------------

    def _tell(self, now: float) -> None:
        if self._wanted is None:
            return
        self._told_at = now
        state, text = self.state, self._why_waiting(now)
        speed = 0.0
        if state is not None and state.velocity is not None and state.velocity.vx is not None:
            speed = state.velocity.vx
        left = self._wanted.route.length if self._order is None else self._left(self._order)
        self._out.append(Progress(self._wanted.id, left, speed, text))

    def _left(self, order: OrderPlan) -> float:
        return order.between(order.position(order.reached), len(order.nodes) - 1)

    def _why_waiting(self, now: float) -> str:
        if self._broken_at is not None:
            return f"the connection of the AGV has been broken for {now - self._broken_at:.0f} s"
        if self.state is None:
            return "the AGV has sent no state"
        if self.stale:
            return self.stale
        if self._cancelling.active:
            return "the AGV is to cancel the order before"
        return standing(self.state)


def _begins_with(route: Route, rest: Route, place: tuple[float, float]) -> bool:
    """Return whether a route leads along the rest of another one, up to a place."""
    back = rest.before(*place)
    return all(route.after(x, y, NEAR) is not None for x, y in back.points.tolist())
