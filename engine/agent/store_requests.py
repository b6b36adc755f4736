"""Requests of containers to the stores, which their machine executes: checkpoints, logs, plans and planning history.

A container only reaches the checkpoint of its own clone, and plans of its own map version. A plan has the access rights
of its map, and a container runs on a map only if its user may read that map.
"""

from collections import OrderedDict
from threading import Lock

import msgspec

from engine.protocols import machine_link
from engine.protocols.machine_link import stored_plan
from engine.specs.checkpoints import log_name, marks, of_session
from engine.specs.containers import ContainerSpec
from ppaas.clock import epoch
from ppaas.errors import NotFound, NotPermitted
from ppaas.geometry import Pose2D
from ppaas.plans import stored
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.plans.reuse.criteria import best_candidates
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import CloneCheckpoint, PlanPassage, PlanRecord

# -- clones ------------------------------------------------------------------------------------------------------------


LOG_PAGE = 16
"""Number of entries of a log that are read from the store at once."""


LOG_BYTES = 8 << 20
"""Size of an answer with entries of a log, about [bytes]."""


class CloneService:
    """Executes the clone requests of containers; its methods may block.

    Parameters
    ----------
    store : Store
        Store of checkpoints and logs.
    """

    def __init__(self, store: Store) -> None:
        self._store = store

    def save(self, spec: ContainerSpec, frame: machine_link.SaveClone, cloud: str) -> None:
        """Store a checkpoint, with changes of logs; ``cloud`` names the cloud process of the machine.

        Raises
        ------
        NotPermitted
            The container has no clone.
        """
        name = _checkpoint_name(spec)
        checkpoint = CloneCheckpoint(spec.user, name, frame.nodes | marks(spec, cloud), epoch())
        if not frame.changes:
            self._store.save_clone(checkpoint)
        for change in frame.changes:
            self._store.save_clone(checkpoint, of_session(spec, change))

    def log(self, spec: ContainerSpec, asked: machine_link.ReadLog) -> machine_link.LogRead:
        """Return entries of a node's log, about `LOG_BYTES` of them.

        Raises
        ------
        NotPermitted
            The container has no clone.
        """
        clone, name, entries = _checkpoint_name(spec), log_name(spec, asked.node), list[tuple[int, bytes]]()
        while sum(len(data) for _, data in entries) < LOG_BYTES:
            after = entries[-1][0] if entries else asked.after
            found = self._store.clone_log(spec.user, clone, name, after=after, limit=LOG_PAGE)
            entries += found
            if len(found) < LOG_PAGE:
                break
        return machine_link.LogRead(asked.request, entries)


def _checkpoint_name(spec: ContainerSpec) -> str:
    if not spec.checkpoint_name:
        raise NotPermitted("a planning container has no clone, so neither a checkpoint nor a log")
    return spec.checkpoint_name


# -- plans -------------------------------------------------------------------------------------------------------------


POSE = 7 * 8
"""Size of a pose: 7 float64 values [bytes]."""


MOST_BYTES = 16 << 20
"""Default capacity of the cache, in poses [bytes]."""


class RecentPlans:
    """Least-recently-used cache of plans in front of the store; thread-safe.

    Parameters
    ----------
    store : Store
        Store of plans.
    most_bytes : int
        Capacity, counted in the poses of the cached plans [bytes].
    """

    def __init__(self, store: Store, most_bytes: int = MOST_BYTES) -> None:
        self._store = store
        self._most = most_bytes
        self._bytes = 0
        self._plans: OrderedDict[str, PlanRecord] = OrderedDict()
        self._lock = Lock()

    def plan(self, head: PlanRecord) -> PlanRecord:
        """Return the whole plan of a head that a query returned; ``NotFound`` if it was removed since.

        A cached plan is returned only if its head is equal to the given one, since plans may be replaced.
        """
        with self._lock:
            known = self._plans.get(head.id)
            if known is not None and msgspec.structs.replace(known, poses=b"") == head:
                self._plans.move_to_end(head.id)
                return known
        plan = self._store.plan(head.id)
        with self._lock:
            self._remember(plan)
        return plan

    def _remember(self, plan: PlanRecord) -> None:
        before = self._plans.pop(plan.id, None)
        self._bytes += len(plan.poses) - (len(before.poses) if before is not None else 0)
        self._plans[plan.id] = plan
        while self._bytes > self._most:
            _, dropped = self._plans.popitem(last=False)
            self._bytes -= len(dropped.poses)


class PlanService:
    """Executes the plan requests of containers; its methods may block.

    Parameters
    ----------
    store : Store
        Store of plans and history.
    link : str
        Name of the network link from this machine to the store, in the history.
    """

    def __init__(self, store: Store, link: str) -> None:
        self._store = store
        self._recent = RecentPlans(store)
        self._link = link

    def keep(self, spec: ContainerSpec, plan: PlanRecord) -> None:
        """Store a plan; storing the same plan again changes nothing.

        Raises
        ------
        NotPermitted
            The plan does not have the container's user, robot and map version, or the map is not published.
        """
        if spec.maps:
            raise NotPermitted("plans on a map that is not published are not stored")
        robot = spec.robot.id if spec.robot is not None else None
        if (plan.user, plan.robot, plan.map, plan.version) != (spec.user, robot, spec.map.id, spec.map.version):
            raise NotPermitted("a container may only store plans with its own user, robot and map version")
        self._store.add_plan(plan)

    def find(self, spec: ContainerSpec, asked: machine_link.FindPlans) -> list[machine_link.PlanCandidate]:
        """Return candidates for reuse: plans from start to goal or, without any, segments of plans that pass both."""
        if spec.maps:
            return []
        version, tolerance = spec.map.version, asked.tolerance
        query = stored.PlanQuery(
            Pose2D(*asked.start), Pose2D(*asked.goal), version, asked.planner, asked.parameters, asked.robot_radius,
            tolerance, asked.kinematic,
        )  # fmt: skip
        search = PlanStoreQuery(spec.map.id, version, asked.start, asked.goal, tolerance)
        heads = {head.id: head for head in self._store.find_plans(search)}
        fit = best_candidates(query, [_seen(head) for head in heads.values()])
        found = [candidate for each in fit for candidate in self._whole(heads[each.id])]
        if found or asked.kinematic:
            return found
        passages = self._store.plans_through(msgspec.structs.replace(search, planner=asked.planner))
        by_id = {passage.head.id: passage for passage in passages}
        fit = best_candidates(query, [_seen(passage.head) for passage in passages], most=1)
        return [candidate for each in fit for candidate in self._stretch(by_id[each.id])]

    def _whole(self, head: PlanRecord) -> list[machine_link.PlanCandidate]:
        try:
            return [machine_link.PlanCandidate(self._recent.plan(head))]
        except NotFound:
            return []  # it was removed since the query

    def _stretch(self, passage: PlanPassage) -> list[machine_link.PlanCandidate]:
        part = slice(passage.first * POSE, (passage.last + 1) * POSE)
        whole = [found.plan for found in self._whole(passage.head)]
        return [
            machine_link.PlanCandidate(msgspec.structs.replace(plan, poses=plan.poses[part]), whole=False)
            for plan in whole
        ]

    def history(self, spec: ContainerSpec) -> machine_link.PlanningHistory:
        """Return the history of planning on the container's map, and of the link to the store."""
        known = {row.link: row for row in self._store.links()}
        rows = [] if spec.maps else self._store.history(spec.map.id)
        return machine_link.PlanningHistory(0, rows, self._link, known.get(self._link))

    def note(self, spec: ContainerSpec, rows: list[PlannerHistory], link: LinkHistory | None) -> None:
        """Add rows to the history of planning, and replace the link's history.

        Raises
        ------
        NotPermitted
            A row is about another map version, or the link is another one.
        """
        if any((row.map, row.version) != (spec.map.id, spec.map.version) for row in rows):
            raise NotPermitted("a container may only add history about its own map version")
        if rows:
            self._store.add_history(rows)
        if link is not None:
            if link.link != self._link:
                raise NotPermitted(
                    f"this machine only stores history about its own link {self._link!r}, not {link.link!r}"
                )
            self._store.put_link(link)


def _seen(head: PlanRecord) -> stored.StoredPlan:
    return stored_plan(machine_link.PlanCandidate(msgspec.structs.replace(head, poses=b"")))
