"""Kinds of records that a migration copies between stores: users, robots, checkpoints, people, tasks, buildings,
webhooks, plans.

Records that belong to no user, such as a checkpoint written after its robot was removed, cannot be reached by any
request and are not copied.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import Any

from msgspec.structs import replace

from ppaas.errors import NotFound
from ppaas.messages.health.stops import STOPS_RECORD
from ppaas.people.names import coordinator_checkpoint
from ppaas.traffic.taking_part import takes_part, traffic_checkpoint
from storage.alerts.acknowledgements import ALERTS_RECORD, CLOUD
from storage.buildings.records import BuildingRecord
from storage.migration.copying import PAGE, Key, StoredKind, by_pages, each
from storage.names import Group
from storage.people import BEFORE_ALL, MapPeople, PeopleCount
from storage.ports import Store
from storage.records import CloneCheckpoint, CloneLogChange, MapTask, PlanRecord, RobotRecord, Token
from storage.webhooks.records import WebhookDelivery

LOG_PAGE = 16
"""Entries of the log of a clone that are copied at once."""

LISTED = 16 * PAGE
"""Plans that are listed at once."""


def _user_ids(store: Store) -> Iterator[list[str]]:
    pages = by_pages(lambda after: store.users(after=after, limit=PAGE), "", lambda user: user.id)
    return ([user.id for user in page] for page in pages)


def _token_hashes(store: Store) -> Iterator[list[str]]:
    def of(owner: str) -> Iterator[list[Token]]:
        return by_pages(lambda after: store.tokens(owner, after=after, limit=PAGE), "", lambda token: token.hash)

    pages = (page for owner in chain.from_iterable(_user_ids(store)) for page in of(owner))
    return ([token.hash for token in page] for page in pages)


def _robots(store: Store) -> Iterator[list[RobotRecord]]:
    def of(owner: str) -> Iterator[list[RobotRecord]]:
        return by_pages(lambda after: store.robots(owner, after=after, limit=PAGE), "", lambda robot: robot.id)

    return (page for owner in chain.from_iterable(_user_ids(store)) for page in of(owner))


def _robot_keys(store: Store) -> Iterator[list[Key]]:
    return ([(robot.user, robot.id) for robot in page] for page in _robots(store))


def _clone_keys(store: Store) -> Iterator[list[Key]]:
    """Yield the keys of checkpoints: of clones, of the nodes of groups (coordinators, traffic), of stops, of alerts."""
    groups = ([(people.user, coordinator_checkpoint(people.map))] for people in _people(store))
    of_users = ([(user, name) for user in page for name in (STOPS_RECORD, ALERTS_RECORD)] for page in _user_ids(store))
    pages = chain(_robot_keys(store), groups, _traffic_keys(store), of_users, [[(CLOUD, ALERTS_RECORD)]])
    return ([key for key in page if _has(_clone, store, key)] for page in pages)


def _traffic_keys(store: Store) -> Iterator[list[Key]]:
    """Yield the keys of the checkpoints of traffic nodes: for the maps of robots that take part, each once."""
    robots = chain.from_iterable(_robots(store))
    groups = dict.fromkeys((robot.user, robot.map) for robot in robots if takes_part(robot.parameters))
    return ([(user, traffic_checkpoint(map_id))] for user, map_id in groups)


def _beside_robots(read: Callable[[Store, Any], object]) -> Callable[[Store], Iterator[list[Key]]]:
    """Return a function that yields the keys of the robots for which ``read`` finds a record."""

    def pages(store: Store) -> Iterator[list[Key]]:
        return ([key for key in page if _has(read, store, key)] for page in _robot_keys(store))

    return pages


def _has(read: Callable[[Store, Any], object], store: Store, key: Key) -> bool:
    try:
        read(store, key)
    except NotFound:
        return False
    return True


def _plan_ids(store: Store) -> Iterator[list[str]]:
    """Yield the ids of plans in pages. Lists are longer than pages, because a store may read more than it returns."""

    def of(map_id: str) -> Iterator[list[PlanRecord]]:
        return by_pages(
            lambda before: store.plans(map_id, before=before, limit=LISTED), None, lambda plan: (plan.created, plan.id)
        )

    listed = ([plan.id for plan in page] for map_id in store.plan_maps() for page in of(map_id))
    return (ids[at : at + PAGE] for ids in listed for at in range(0, len(ids), PAGE))


def _history_keys(store: Store) -> Iterator[list[Key]]:
    return ([row.key for row in store.history(map_id)] for map_id in store.history_maps())


def _read_history(store: Store, keys: Sequence[Any]) -> dict[Key, Any]:
    wanted = set(keys)
    rows = chain.from_iterable(store.history(map_id) for map_id in dict.fromkeys(key[0] for key in keys))
    return {row.key: row for row in rows if row.key in wanted}


def _read_links(store: Store, keys: Sequence[Key]) -> dict[Key, Any]:
    return {row.link: row for row in store.links() if row.link in keys}


def _people(store: Store) -> Iterator[MapPeople]:
    return chain.from_iterable(map(store.people_of_map, store.people_maps()))


def _people_keys(store: Store) -> Iterator[list[Key]]:
    return ([record.key for record in store.people_of_map(map_id)] for map_id in store.people_maps())


def _read_people(store: Store, keys: Sequence[Any]) -> dict[Key, Any]:
    wanted = set(keys)
    records = chain.from_iterable(map(store.people_of_map, dict.fromkeys(map_id for _, map_id in keys)))
    return {record.key: record for record in records if record.key in wanted}


def _count_keys(store: Store) -> Iterator[list[Key]]:
    def of(people: MapPeople) -> Iterator[list[PeopleCount]]:
        return by_pages(
            lambda after: store.people_counts(*people.key, after=after, limit=PAGE),
            BEFORE_ALL,
            lambda row: (row.hour, row.zone),
        )

    return ([row.key for row in page] for people in _people(store) for page in of(people))


def _read_counts(store: Store, keys: Sequence[Any]) -> dict[Key, Any]:
    """Return the counts of a page of keys, which belong to one user on one map, in order."""
    if not keys:
        return {}
    wanted, (user, map_id, hour, _) = set(keys), keys[0]
    found: dict[Key, Any] = {}
    pages = by_pages(
        lambda after: store.people_counts(user, map_id, after=after, limit=PAGE),
        (hour - 1, ""),
        lambda row: (row.hour, row.zone),
    )
    for page in pages:
        found |= {row.key: row for row in page if row.key in wanted}
        if page[-1].key >= keys[-1]:
            break
    return found


def _task_keys(store: Store) -> Iterator[list[Key]]:
    def of(group: Group) -> Iterator[list[MapTask]]:
        return by_pages(lambda after: store.tasks(*group, after=after, limit=PAGE), "", lambda record: record.task.id)

    return ([record.key for record in page] for group in store.task_groups() for page in of(group))


def _building_keys(store: Store) -> Iterator[list[Key]]:
    def of(user: str) -> Iterator[list[BuildingRecord]]:
        return by_pages(lambda after: store.buildings(user, after=after, limit=PAGE), "", lambda record: record.id)

    return ([record.key for record in page] for user in store.building_users() for page in of(user))


def _webhook_keys(store: Store) -> Iterator[list[Key]]:
    return ([hook.key for hook in store.webhooks(user)] for user in store.webhook_users())


def _delivery_keys(store: Store) -> Iterator[list[Key]]:
    def of(hook: Key) -> Iterator[list[WebhookDelivery]]:
        return by_pages(lambda after: store.deliveries(*hook, after=after, limit=PAGE), "", lambda record: record.id)

    hooks = chain.from_iterable(_webhook_keys(store))
    return ([record.key for record in page] for hook in hooks for page in of(hook))


def _urdf(store: Store, key: Any) -> tuple[str, str, bytes]:
    return (*key, store.urdf(*key))


def _clone(store: Store, key: Any) -> Any:
    return store.clone(*key)


def _add_clones(source: Store, target: Store, clones: Sequence[CloneCheckpoint]) -> None:
    for clone in clones:
        _add_clone(source, target, clone)


def _add_clone(source: Store, target: Store, clone: CloneCheckpoint) -> None:
    """Copy the logs with a checkpoint without nodes, and then the checkpoint: an interrupted copy is recognized."""
    begun = replace(clone, nodes={})
    for log in source.clone_logs(clone.user, clone.robot):
        after = -1
        while entries := source.clone_log(clone.user, clone.robot, log, after=after, limit=LOG_PAGE):
            target.save_clone(begun, CloneLogChange(log, dict(entries)))
            after = entries[-1][0]
    target.save_clone(clone)


def _replace_clone(source: Store, target: Store, clone: CloneCheckpoint, _before: CloneCheckpoint) -> None:
    target.remove_clone(clone.user, clone.robot)
    _add_clone(source, target, clone)


def _one_by_one(
    name: str,
    pages: Callable[[Store], Iterator[list[Key]]],
    read: Callable[[Store, Sequence[Key]], dict[Key, Any]],
    put: Callable[..., object],
    change: Callable[[Store, Any, Any], object] | None = None,
    *,
    exact: bool = True,
) -> StoredKind[Store]:
    """Return a kind whose records are written one by one.

    ``put`` adds a record to a store. ``change`` replaces the last argument, a record, by the one before it; without it,
    ``put`` does so.
    """

    def add(_source: Store, target: Store, records: Sequence[Any]) -> None:
        for record in records:
            put(target, record)

    def replaced(_source: Store, target: Store, record: Any, before: Any) -> None:
        if change is None:
            put(target, record)
        else:
            change(target, record, before)

    return StoredKind(name, pages, read, add, replaced, exact=exact)


KINDS: tuple[StoredKind[Store], ...] = (
    _one_by_one(
        "users",
        _user_ids,
        each(lambda store, key: store.user(key)),
        lambda store, user: store.add_user(user),
        lambda store, user, _before: store.change_user(user),
    ),
    _one_by_one(
        "tokens", _token_hashes, each(lambda store, key: store.token(key)), lambda store, token: store.add_token(token)
    ),
    _one_by_one(
        "robots",
        _robot_keys,
        each(lambda store, key: store.robot(*key)),
        lambda store, robot: store.put_robot(robot),
        lambda store, robot, before: store.put_robot(robot, instead_of=before),
    ),
    _one_by_one("URDFs", _beside_robots(_urdf), each(_urdf), lambda store, urdf: store.put_urdf(*urdf)),
    StoredKind(
        "checkpoints",
        _clone_keys,
        each(_clone),
        _add_clones,
        _replace_clone,
        lambda clone, there: there == replace(clone, nodes={}),
    ),
    _one_by_one(
        "people",
        _people_keys,
        _read_people,
        lambda store, people: store.put_people_settings(people),
        lambda store, people, before: store.put_people_settings(people, instead_of=before),
    ),
    StoredKind(
        "counts",
        _count_keys,
        _read_counts,
        lambda _source, target, rows: target.add_people_counts(rows),
        lambda _source, target, row, _before: target.add_people_counts([row]),
        exact=False,
    ),
    _one_by_one(
        "tasks",
        _task_keys,
        each(lambda store, key: store.task(*key)),
        lambda store, task: store.put_task(task),
        lambda store, task, before: store.put_task(task, instead_of=before),
    ),
    _one_by_one(
        "buildings",
        _building_keys,
        each(lambda store, key: store.building(*key)),
        lambda store, building: store.put_building(building),
        lambda store, building, before: store.put_building(building, instead_of=before),
    ),
    _one_by_one(
        "webhooks",
        _webhook_keys,
        each(lambda store, key: store.webhook(*key)),
        lambda store, hook: store.put_webhook(hook),
        lambda store, hook, before: store.put_webhook(hook, instead_of=before),
    ),
    _one_by_one(
        "deliveries",
        _delivery_keys,
        each(lambda store, key: store.delivery(*key)),
        lambda store, delivery: store.put_delivery(delivery),
    ),
    StoredKind(
        "plans",
        _plan_ids,
        lambda store, keys: store.whole_plans(keys),
        lambda _source, target, plans: target.add_plans(plans),
        lambda _source, target, plan, before: target.replace_plan(plan, instead_of=before),
        count=lambda store: store.plan_statistics().plans,
    ),
    StoredKind(
        "history",
        _history_keys,
        _read_history,
        lambda _source, target, rows: target.add_history(rows),
        exact=False,
    ),
    _one_by_one(
        "links",
        lambda store: iter([[row.link for row in store.links()]]),
        _read_links,
        lambda store, link: store.put_link(link),
        exact=False,
    ),
)
"""All kinds in the order of a migration: owners come before what they own."""
