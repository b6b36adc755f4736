"""The ports: what the engine and the endpoints ask of a store, whatever keeps it.

All methods are synchronous and may block; callers on an event loop run them in a thread. A store is safe to use from
several threads. What a store cannot do now it says with ``Unavailable``; what is not there with ``NotFound``. A name
that no store takes (``storage.names``) is ``InvalidInput`` wherever it is given.

Lists come in pages. A page begins behind a *key*, the last one of the page before (``after`` where keys ascend,
``before`` where the newest come first), and has ``limit`` records at most; None is all of them. The key need not exist
any more, so what is added or removed meanwhile neither repeats nor hides the rest.
"""

from collections.abc import Collection, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.opened_maps import OpenMap
from storage.plan_query import PlanSearch
from storage.records import (
    CloneCheckpoint,
    MapRecord,
    MapVersionRecord,
    PlanPart,
    PlanPassage,
    PlanRecord,
    PlanStatistics,
    Publication,
    RobotRecord,
    Token,
    User,
)
from storage.staged_uploads import MapDraft
from storage.versions import PARTS


class UserStore(Protocol):
    """Accounts and their tokens."""

    def add_user(self, user: User) -> None:
        """Keep a new user; ``Conflict`` if the id is taken."""
        ...

    def user(self, user_id: str) -> User:
        """Return a user; ``NotFound`` if there is none."""
        ...

    def users(self, *, after: str = "", limit: int | None = None) -> list[User]:
        """Return users by id."""
        ...

    def change_user(self, user: User, *, keep_token: str | None = None) -> None:
        """Keep a user in place of the one before; ``NotFound`` if there is none.

        With another password go all tokens of the user but the one of this hash: who had learned the old one is out.
        """
        ...

    def remove_user(self, user_id: str) -> None:
        """Forget a user with all tokens, robots, their URDFs and checkpoints; ``NotFound`` if there is none.

        All at once, so that nobody who is given the id later comes into what was another's.
        """
        ...

    def add_token(self, token: Token) -> None:
        """Keep a token of a user; ``NotFound`` if the user is no more."""
        ...

    def token(self, token_hash: str) -> Token:
        """Return a token, expired or not; ``NotFound`` if there is none."""
        ...

    def tokens(self, user_id: str, *, after: str = "", limit: int | None = None) -> list[Token]:
        """Return the tokens of a user by hash."""
        ...

    def remove_token(self, token_hash: str) -> None:
        """Forget a token; ``NotFound`` if there is none."""
        ...

    def remove_tokens(self, *, expired_before: float) -> int:
        """Forget the tokens that expired before a time; return how many."""
        ...


class MapStore(Protocol):
    """Maps and their versions. As maps may be large, files are written to drafts and read from open maps in blocks."""

    def drafting(self) -> AbstractContextManager[MapDraft]:
        """Write the files of a version, which are gone at the end of the block unless they were published in it."""
        ...

    def publish(self, draft: MapDraft, said: Publication) -> MapRecord:
        """Make files the present version of a map, at once and whole; return its head.

        Nobody sees a part of it, and what was said of the map stays where nothing else is said. Files that are those of
        the present version publish nothing, so that whoever is not sure may publish again.

        Raises
        ------
        Conflict
            The map is another owner's (two who take an id at the same time can't both have it), or its present version
            is not the one that was expected.
        InvalidInput
            A name is none, or the files are not those of a map.
        """
        ...

    def roll_back(self, version: str, said: Publication) -> MapRecord:
        """Make a version that a map had the present one again; return its head.

        Raises
        ------
        NotFound
            There is no such map, or it never had that version.
        Conflict
            As ``publish``.
        """
        ...

    def open_map(
        self, map_id: str, version: str | None = None, *, only: Collection[str] = PARTS
    ) -> AbstractContextManager[OpenMap]:
        """Read the files of a version, or only some of them: the present one, or as another was published.

        Raises
        ------
        NotFound
            There is no such map, or it never had that version.
        Unavailable
            They are not what was published.
        """
        ...

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its present version; ``NotFound`` if there is none."""
        ...

    def maps(self, visible_to: str | None = None, *, after: str = "", limit: int | None = None) -> list[MapRecord]:
        """Return the maps that a user may read, or all, by id, in their present versions."""
        ...

    def versions(self, map_id: str, *, before: int | None = None, limit: int | None = None) -> list[MapVersionRecord]:
        """Return what was published under an id, newest first, the key being a number; ``NotFound`` if there is none.

        What was restored comes twice: as it was published, and as it was restored.
        """
        ...

    def change_map(
        self, map_id: str, *, readers: tuple[str, ...] | None = None, description: str | None = None
    ) -> MapRecord:
        """Change what is said of a map, and none of its files; return its head. ``NotFound`` if there is none."""
        ...

    def remove_map(self, map_id: str) -> None:
        """Forget a map and its versions; ``NotFound`` if there is none."""
        ...


class RobotStore(Protocol):
    """Robots, each the user's own: two users may have robots of the same id."""

    def put_robot(self, record: RobotRecord, *, instead_of: RobotRecord | None = None) -> bool:
        """Keep a robot or change it; tell whether it is new.

        Raises
        ------
        Conflict
            What is kept is not what this should take the place of: another was faster.
        """
        ...

    def robot(self, user: str, robot_id: str) -> RobotRecord:
        """Return a robot; ``NotFound`` if there is none."""
        ...

    def robots(self, user: str, *, after: str = "", limit: int | None = None) -> list[RobotRecord]:
        """Return the robots of a user by id."""
        ...

    def remove_robot(self, user: str, robot_id: str) -> None:
        """Forget a robot, its URDF and its clone's checkpoint; ``NotFound`` if there is none."""
        ...

    def put_urdf(self, user: str, robot_id: str, urdf: bytes) -> bool:
        """Keep the URDF of a robot in place of the one before; tell whether it is new.

        Raises
        ------
        NotFound
            There is no such robot.
        """
        ...

    def urdf(self, user: str, robot_id: str) -> bytes:
        """Return the URDF of a robot, byte for byte; ``NotFound`` if there is none."""
        ...

    def remove_urdf(self, user: str, robot_id: str) -> None:
        """Forget the URDF of a robot; ``NotFound`` if there is none."""
        ...


class PlanStore(Protocol):
    """The Path Plan Database: plans, of which equal stretches are kept once.

    A place is (x, y) [m] in the frame of the map. A plan that cannot be one (``storage.plan_checks``) is
    ``InvalidInput``.
    """

    def add_plan(self, record: PlanRecord) -> None:
        """Keep a plan; keeping the same id twice changes nothing."""
        ...

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans, all or none; return how many were not there before. Of an id that comes twice, the first."""
        ...

    def replace_plan(self, record: PlanRecord, *, instead_of: PlanRecord) -> None:
        """Keep a plan in place of the one of the same id.

        Raises
        ------
        Conflict
            What is kept is not what this should take the place of: another was faster.
        NotFound
            None of this id is kept.
        """
        ...

    def plan(self, plan_id: str) -> PlanRecord:
        """Return a plan, its poses bit for bit as they were given; ``NotFound`` if there is none."""
        ...

    def whole_plans(self, plan_ids: Sequence[str]) -> dict[str, PlanRecord]:
        """Return those of some plans that are kept, by id, as ``plan`` does each."""
        ...

    def plans(
        self, map_id: str, *, before: tuple[float, str] | None = None, limit: int | None = None
    ) -> list[PlanRecord]:
        """Return the heads of the plans of a map, newest first; the key is when one was made, and its id."""
        ...

    def plan_maps(self) -> list[str]:
        """Return the ids of the maps that have plans, sorted; the maps themselves may be gone."""
        ...

    def find_plans(self, search: PlanSearch, *, limit: int = 16) -> list[PlanRecord]:
        """Return the heads of plans whose first pose lies near one place and whose last near another, shortest first.

        Parameters
        ----------
        search : PlanSearch
            Which are sought.
        limit : int
            The most that are returned. Where there are more, lengths count to a 16th of a metre, and which of equally
            long ones are returned is not said; of those that are as long, planned alike, and begin and end within two
            centimetres of each other, some may be missed.
        """
        ...

    def plans_through(self, search: PlanSearch, *, limit: int = 8) -> list[PlanPassage]:
        """Return plans that pass near one place and later near another, the shortest passage first.

        Parameters are those of ``find_plans``. It looks at a bounded number of plans, so it may miss some: what it
        returns is right, but another may be shorter.
        """
        ...

    def plan_parts(self, plan_id: str) -> list[PlanPart]:
        """Return the stretches of a plan that are entries of their own, in order; ``NotFound`` if there is none."""
        ...

    def plan_statistics(self, map_id: str | None = None) -> PlanStatistics:
        """Return what the plans of a map take, or all."""
        ...

    def remove_plan(self, plan_id: str) -> None:
        """Forget a plan; ``NotFound`` if there is none. Entries that other plans refer to stay."""
        ...

    def remove_plans(self, map_id: str) -> int:
        """Forget the plans of a map, some at a time; return how many. What was cut off goes on when it is repeated."""
        ...


class CloneStore(Protocol):
    """Checkpoints of clones."""

    def save_clone(self, checkpoint: CloneCheckpoint) -> None:
        """Keep a checkpoint in place of the one before."""
        ...

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        """Return the last checkpoint; ``NotFound`` if there is none."""
        ...

    def remove_clone(self, user: str, robot: str) -> None:
        """Forget the checkpoint, if there is one."""
        ...


class HistoryStore(Protocol):
    """What became of requests for plans, in sums: some hundred rows a map version, however many requests there were.

    A row has a key of four and is added to what is kept under it, so a store may count. What is told twice counts
    twice, and what could not be kept is lost: nothing but estimates and tables is made of it.
    """

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to what is kept under its key (``storage.history_checks``)."""
        ...

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, by key."""
        ...

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        ...

    def remove_history(self, map_id: str) -> None:
        """Forget the rows of a map, if it has any."""
        ...

    def put_link(self, row: LinkHistory) -> None:
        """Keep what was measured of a link in place of what was before."""
        ...

    def links(self) -> list[LinkHistory]:
        """Return what was measured of all links, by name."""
        ...


class Store(UserStore, RobotStore, PlanStore, HistoryStore, CloneStore, Protocol):
    """Everything but maps: small records, many of them."""

    def close(self) -> None:
        """Let go of files and connections; use nothing of it afterwards."""
        ...
