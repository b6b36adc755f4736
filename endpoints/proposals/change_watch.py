"""Change watch: looks at robots that map for life, and proposes the changes of their maps that they have confirmed."""

import contextlib
import json
import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool

from endpoints.audit.event import AuditEvent
from endpoints.proposals.compared_files import BEFORE, PARTS, SETTINGS
from endpoints.resources.heavy_work import callable_in_thread
from endpoints.resources.services import Services
from endpoints.rest.maps.map_programs import MAKE_SECONDS, run_program
from endpoints.rest.maps.version_proposals import check_may_propose, propose
from engine.control.views import LifelongRobot
from engine.processes.background import repeat
from ppaas.clock import epoch
from ppaas.errors import PPaaSError
from ppaas.mapping.lifelong.changed_places import NOTHING, ChangedPlace, KnownChanges, centres, is_among
from ppaas.messages.slam_toolbox import GetPoseGraphResponse
from storage.records import ConfirmedPlaces, MapRecord, MapReview, Publication, User
from storage.staged_uploads import StagedUpload, blocks, mapped
from storage.store_errors import disk_errors
from storage.temporary import temporary_folder
from storage.versions import ONLY_ZONES, POSEGRAPH, ZONES

if TYPE_CHECKING:
    from endpoints.proposals import change_program  # noqa: F401 - the program named below


logger = logging.getLogger(__name__)


# Findings of robots in the reviews of a map: written with a proposal, and read so that none is proposed again.


def confirmed_places(robot: str, left: Sequence[ChangedPlace], new: Sequence[ChangedPlace]) -> ConfirmedPlaces:
    """Return what a review stores of the places that a robot found gone and new.

    The search for changes bounds their number: each entry of a map's log has the places of all its reviews.
    """
    return ConfirmedPlaces(robot, _rounded(left), _rounded(new))


def waits(reviews: Iterable[MapReview], robot: LifelongRobot) -> bool:
    """Return whether a proposal of a robot waits for its review."""
    return any(
        review.waits and review.author == robot.user and confirmed.robot == robot.robot
        for review in reviews
        if (confirmed := review.change.confirmed) is not None
    )


def known_changes(reviews: Iterable[MapReview]) -> KnownChanges:
    """Return the changes that robots have proposed and that wait or were refused."""
    found = [
        confirmed
        for review in reviews
        if review.state != "approved" and (confirmed := review.change.confirmed) is not None
    ]
    return KnownChanges([place for one in found for place in one.left], [place for one in found for place in one.new])


def _rounded(places: Sequence[ChangedPlace]) -> tuple[tuple[float, float], ...]:
    """Return the centres of places, rounded to centimetres."""
    return tuple((round(x, 2), round(y, 2)) for x, y in centres(places))


# Reasons of proposals: which robot found a change, what is gone and what is new.

MOST_PLACES = 6
"""Largest number of places of a kind that a reason names; it gives the number of all."""


def reason_of(robot: str, left: Sequence[ChangedPlace], new: Sequence[ChangedPlace]) -> str:
    """Return the reason of a proposal.

    Parameters
    ----------
    robot : str
        Id of the robot.
    left, new : sequence of ChangedPlace
        Places where something is gone, and places where something is new; the largest first.
    """
    kinds = [f"{name}: {_listed(places)}" for name, places in (("gone", left), ("new", new)) if places]
    return f"{robot}: two passes show {'; '.join(kinds)}"


def _listed(places: Sequence[ChangedPlace]) -> str:
    named = [f"{one.width:.2f} × {one.height:.2f} m at ({one.x:.2f}, {one.y:.2f})" for one in places[:MOST_PLACES]]
    more = [f"and {len(places) - MOST_PLACES} more"] if len(places) > MOST_PLACES else []
    cells = sum(place.cells for place in places)
    return f"{len(places)} place{'s' * (len(places) > 1)}, {cells} cells, {', '.join([*named, *more])}"


_PROGRAM = "endpoints.proposals.change_program"

PERIOD = 60.0
"""Time between two looks at the maps of the robots [s]."""


Places = tuple[list[ChangedPlace], list[ChangedPlace]]
"""Places where something is gone, and places where something is new."""


@dataclass(frozen=True, slots=True)
class _Taken:
    """Pose graph of a robot, and the parameters of its map."""

    posegraph: bytes
    numbers: GetPoseGraphResponse


class ChangeWatch:
    """Proposes changes, at most one version of a robot and a map at once.

    A change is proposed when two looks in a row have found it, since people stand for some time. It is not proposed
    again while it waits for its review, or after it was refused.

    Parameters
    ----------
    services : Services
    """

    def __init__(self, services: Services) -> None:
        self._services, self._cloud = services, services.cloud
        self._seen: dict[LifelongRobot, tuple[int, ...]] = {}
        self._found: dict[LifelongRobot, KnownChanges] = {}
        self._errors: dict[LifelongRobot, str] = {}

    async def run(self) -> None:
        """Propose changes until cancelled."""
        await repeat(self.step, PERIOD)

    async def step(self) -> None:
        """Look at all robots once."""
        robots = await self._cloud.maps.lifelong_robots()
        for notes in (self._seen, self._found, self._errors):
            for robot in notes.keys() - set(robots):
                del notes[robot]
        for robot in robots:
            try:
                await self._look(robot)
                self._errors.pop(robot, None)
            except PPaaSError as error:
                if self._errors.get(robot) != str(error):
                    self._errors[robot] = str(error)
                    logger.info("map %r is not compared with that of robot %r: %s", robot.map, robot.robot, error)

    async def _look(self, robot: LifelongRobot) -> None:
        """Propose what a robot has found, if its map or the published one has changed and no proposal of it waits."""
        numbers = await self._cloud.nodes.map(robot.user, robot.robot, -1)
        head, reviews = await run_in_threadpool(_reviewed, self._services, robot)
        state = head.present.number, numbers.key_frames, numbers.edges, numbers.scans
        if self._seen.get(robot) == state:
            return
        if POSEGRAPH not in head.present.files or waits(reviews, robot):
            return
        file, first = await self._services.posegraphs.fetch(self._cloud.nodes, robot.user, robot.robot)
        known = known_changes(reviews)
        self._seen[robot] = state
        store = callable_in_thread(partial(propose, self._services))
        async with self._services.heavy_work.turn(robot.user):
            found = await run_in_threadpool(self._propose, robot, head, _Taken(file, first), known, store)
        if found is not None:
            self._record(robot, found)

    def _propose(
        self,
        robot: LifelongRobot,
        head: MapRecord,
        taken: _Taken,
        known: KnownChanges,
        store: Callable[[User, StagedUpload, Publication, ConfirmedPlaces], MapReview],
    ) -> MapReview | None:
        """Propose the changes of a map; None if there are none. Blocks."""
        services = self._services
        with temporary_folder() as folder, services.map_store.stage() as upload:
            self._write(folder, head, taken.posegraph)
            left, new = self._twice_found(robot, folder, taken.numbers, known)
            if not left and not new:
                return None
            for part in PARTS:
                upload.add(part, blocks(mapped(folder / part)))
            self._add_others(upload, head)
            message = reason_of(robot.robot, left, new)
            publication = Publication(head.id, robot.user, epoch(), message, if_match=head.version)
            confirmed = confirmed_places(robot.robot, left, new)
            return store(services.store.user(robot.user), upload, publication, confirmed)

    def _twice_found(
        self, robot: LifelongRobot, folder: Path, numbers: GetPoseGraphResponse, known: KnownChanges
    ) -> Places:
        """Return what is gone and what is new, that the last look has found too; the changed map is in the folder."""
        left, new = _compared(folder, numbers, known)
        before, self._found[robot] = (
            self._found.get(robot, NOTHING),
            KnownChanges(centres(left), centres(new)),
        )
        kept = (
            [place for place in left if is_among(place, before.left)],
            [place for place in new if is_among(place, before.new)],
        )
        if kept == (left, new):
            return kept
        self._seen.pop(robot, None)  # the next look decides, even if the robot stands
        if not any(kept):
            return kept
        fresh = [[place for place in found if place not in of] for found, of in zip((left, new), kept, strict=True)]
        known = KnownChanges([*known.left, *centres(fresh[0])], [*known.new, *centres(fresh[1])])
        rest = _compared(folder, numbers, known)
        if any(place not in of for found, of in zip(rest, kept, strict=True) for place in found):
            return [], []  # the largest ones were left out, so smaller ones are found that the last look lacks
        return rest

    def _write(self, folder: Path, head: MapRecord, posegraph: bytes) -> None:
        with contextlib.ExitStack() as stack, disk_errors(folder):
            opened = stack.enter_context(self._services.map_store.open_map(head.id, head.version, only=PARTS))
            for part in PARTS:
                with (folder / f"{BEFORE}{part}").open("wb") as file:
                    file.writelines(blocks(opened.buffer(part)))
            (folder / POSEGRAPH).write_bytes(posegraph)

    def _add_others(self, upload: StagedUpload, head: MapRecord) -> None:
        """Add the files of a map that are not compared, such as an octomap; the map's zones are kept anyway."""
        upload.keeps = ONLY_ZONES
        others = head.present.files.keys() - {*PARTS, ZONES}
        with self._services.map_store.open_map(head.id, head.version, only=others) as opened:
            for part, data in opened.buffers.items():
                upload.add(part, blocks(data))

    def _record(self, robot: LifelongRobot, review: MapReview) -> None:
        details = {"robot": robot.robot, "review": review.number, "version": review.version, "base": review.base}
        self._services.audit.record(
            AuditEvent(action="propose_change", user=robot.user, object=f"maps/{robot.map}", details=details)
        )
        logger.info("review %d of map %r waits: %s", review.number, robot.map, review.message)


def _reviewed(services: Services, robot: LifelongRobot) -> tuple[MapRecord, list[MapReview]]:
    """Return a map of which the robot's user may propose versions, and its reviews. Blocks."""
    head = services.map_store.map_head(robot.map)
    check_may_propose(services, services.store.user(robot.user), head)
    return head, services.map_store.reviews(robot.map)


def _compared(folder: Path, numbers: GetPoseGraphResponse, known: KnownChanges) -> Places:
    """Return what is gone and what is new, without known changes; the program writes the changed map. Blocks."""
    settings = {
        "left": known.left, "new": known.new, "min_pass_through": numbers.min_pass_through,
        "occupancy_threshold": numbers.occupancy_threshold,
    }  # fmt: skip
    with disk_errors(folder):
        (folder / SETTINGS).write_text(json.dumps(settings))
    found: dict[str, Any] = run_program(_PROGRAM, [str(folder)], "the map could not be compared", MAKE_SECONDS)
    left, new = ([ChangedPlace(*place) for place in found[kind]] for kind in ("left", "new"))
    return left, new
