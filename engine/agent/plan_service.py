"""What a machine does for its containers about plans: find and keep them, and the history of planning.

It does so for the map version that a container stands in, and no other: a plan has the rights of its map, and a
container is on a map only because its user may see it.
"""

import msgspec

from engine.agent.recent_plans import RecentPlans
from engine.protocols import machine_link
from engine.protocols.plan_candidates import stored_plan
from engine.specs.containers import ContainerSpec
from ppaas.errors import NotFound, NotPermitted
from ppaas.geometry import Pose2D
from ppaas.plans import stored
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.plans.reuse.criteria import best_candidates
from storage.plan_query import PlanStoreQuery
from storage.ports import Store
from storage.records import PlanPassage, PlanRecord

POSE = 7 * 8
"""Bytes of a pose."""


class PlanDesk:
    """Answers what containers ask about plans; its methods may block.

    Parameters
    ----------
    store : Store
        Where plans and history are kept.
    link : str
        What the way from this machine to the store is called in the history.
    """

    def __init__(self, store: Store, link: str) -> None:
        self._store = store
        self._recent = RecentPlans(store)
        self._link = link

    def keep(self, spec: ContainerSpec, plan: PlanRecord) -> None:
        """Keep a plan; the same one again changes nothing.

        Raises
        ------
        NotPermitted
            It is not of the container's user, robot and map version.
        """
        robot = spec.robot.id if spec.robot is not None else None
        if (plan.user, plan.robot, plan.map, plan.version) != (spec.user, robot, spec.map.id, spec.map.version):
            raise NotPermitted("a plan is kept under the user, robot and map version of its container")
        self._store.add_plan(plan)

    def find(self, spec: ContainerSpec, asked: machine_link.FindPlans) -> list[machine_link.Candidate]:
        """Return plans worth a look: between both ends, or else such as pass by them."""
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

    def _whole(self, head: PlanRecord) -> list[machine_link.Candidate]:
        try:
            return [machine_link.Candidate(self._recent.plan(head))]
        except NotFound:
            return []  # it was removed a moment ago

    def _stretch(self, passage: PlanPassage) -> list[machine_link.Candidate]:
        part = slice(passage.first * POSE, (passage.last + 1) * POSE)
        whole = [found.plan for found in self._whole(passage.head)]
        return [
            machine_link.Candidate(msgspec.structs.replace(plan, poses=plan.poses[part]), whole=False) for plan in whole
        ]

    def history(self, spec: ContainerSpec) -> machine_link.PlanningHistory:
        """Return what is known of planning on the map, and of the link to the store."""
        known = {row.link: row for row in self._store.links()}
        return machine_link.PlanningHistory(0, self._store.history(spec.map.id), self._link, known.get(self._link))

    def note(self, spec: ContainerSpec, rows: list[PlannerHistory], link: LinkHistory | None) -> None:
        """Add to the history.

        Raises
        ------
        NotPermitted
            A row is of another map version, or another link.
        """
        if any((row.map, row.version) != (spec.map.id, spec.map.version) for row in rows):
            raise NotPermitted("history is noted of the map version of the container")
        if rows:
            self._store.add_history(rows)
        if link is not None:
            if link.link != self._link:
                raise NotPermitted(f"history is noted of the link {self._link!r}")
            self._store.put_link(link)


def _seen(head: PlanRecord) -> stored.StoredPlan:
    return stored_plan(machine_link.Candidate(msgspec.structs.replace(head, poses=b"")))
