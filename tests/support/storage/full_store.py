"""Stores with records of all kinds."""

import numpy as np

from ppaas.geometry import poses_along
from ppaas.people.names import coordinator_checkpoint
from ppaas.people.settings import CountingZone, PeopleSettings
from ppaas.plans.history import LinkHistory, PlannerHistory
from ppaas.tasks.records import Task
from ppaas.traffic.taking_part import traffic_checkpoint
from storage.alerts.acknowledgements import CLOUD, Acknowledgement, acknowledge
from storage.people import HOUR, MapPeople, PeopleCount
from storage.ports import MapStore, Store
from storage.records import MapTask, PlanRecord, Publication
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.storage.records import building, clone, house, pgm, plan, put_map, robot, token, user

USERS = ("ann", "bob", "carl")
KINDS = (
    "users",
    "tokens",
    "robots",
    "URDFs",
    "checkpoints",
    "people",
    "counts",
    "tasks",
    "buildings",
    "webhooks",
    "deliveries",
    "plans",
    "history",
    "links",
)

ZONE = CountingZone("door", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
ZONES = ("", "door")


def paths(count: int) -> list[PlanRecord]:
    """Return plans on two maps, some of which share segments."""
    rng = np.random.default_rng(5)
    found = []
    for number in range(count):
        corner = np.cumsum(rng.integers(0, 2, (40, 2)) * 0.05, axis=0) + number % 5
        poses = poses_along(corner, 0.0).astype("<f8").tobytes()
        fields = {"map": "m1" if number % 10 == 0 else "m0", "created": float(number // 2), "cost": number + 0.1}
        found.append(plan(f"p{number:05d}", poses=poses, **fields))
    return found


def fill(store: Store, plans: int = 80, robots: int = 12) -> None:
    """Add records of all kinds to a store, with more plans on one map than fit on a page."""
    for name in USERS:
        store.add_user(user(name, role="admin" if name == "ann" else "user"))
        store.add_token(token(name[0] * 64, user=name, expires=5.0, created=1.0))
    for number in range(robots):
        store.put_robot(robot(f"tb{number}", properties={"number": number, "deep": {"a": [1, None, 2.5]}}))
    store.put_robot(robot("tb1", user="bob", description="of bob", parameters={"amcl": {"min_particles": 5}}))
    store.put_urdf("ann", "tb2", b"<robot name='tb2'/>")
    store.put_urdf("bob", "tb1", bytes(range(256)))
    store.save_clone(clone("tb1", nodes={"amcl": b"\x00\xff", "move_base": b"{}"}))
    store.add_plans(paths(plans))
    store.add_history([PlannerHistory("m0", "v", "dijkstra", 3, queries=7, computed=7, micros=1234)])
    store.add_history([PlannerHistory("m1", version, "astar", 4, queries=1, failed=1) for version in "vw"])
    store.put_people_settings(MapPeople("ann", "m0", PeopleSettings(history=True, zones=[ZONE])))
    store.put_people_settings(MapPeople("bob", "m0"))
    store.put_robot(robot("tb1", user="carl", map="m0", parameters={"traffic": {}}))
    store.save_clone(clone(traffic_checkpoint("m0"), user="carl", nodes={"traffic": b"8"}))
    store.save_clone(clone(coordinator_checkpoint("m0"), nodes={"people_coordinator": b"7"}))
    for owner in ("ann", CLOUD):
        acknowledge(store, owner, Acknowledgement(object="robots/tb1", alert="lost", by="bob", time=5.0))
    store.add_people_counts(PeopleCount("ann", "m0", HOUR * number, zone, 7) for number in range(50) for zone in ZONES)
    for number in range(70):
        task = Task(id=f"k{number}", kind="go_to", places=((1.0, 2.0, 0.5),), labels={"lift": "yes"}, reason="é")
        store.put_task(MapTask("bob" if number == 0 else "ann", "m0", task))
    for number, owner in enumerate(("ann", "bob")):
        store.put_building(building("hq", owner, readers=("*",), versions=1 + number))
    for name in ("wh-1", "wh-2"):
        store.put_webhook(Webhook(user="ann", id=name, url="https://a.b/é", events=("goal.*",), secret=b"\x00\xff"))
    for number in range(70):
        made = WebhookDelivery(user="ann", hook="wh-2", id=f"d{number}", event="goal.reached", body=b"{}", created=1.5)
        store.put_delivery(made)
    store.put_link(LinkHistory("robot-link", 0.02, 1e6, 5, 7.0))


def fill_maps(store: MapStore) -> None:
    """Publish maps with one and with several versions, one of them restored."""
    put_map(store, house("alone", "bob", readers=("ann", "*"), description="one of its kind"))
    versions = [house("house", image=pgm(value=value), created=10.0 + value, readers=("bob",)) for value in range(4)]
    for version in versions:
        put_map(store, version, message=f"as on day {version.created:g}")
    store.roll_back(versions[1].version, Publication("house", "admin", 99.0, "it was better", owner="ann"))
    store.change_map("house", description="a house", readers=("carl",))
