"""Views of ``ppaas people``: tables for a terminal, and plain text."""

import io
import time
from typing import TYPE_CHECKING, Any

from robots.cli.output import cell, duration, table

if TYPE_CHECKING:
    from rich.console import Group

Row = dict[str, Any]

PEOPLE = ("id", "name", "state", "x", "y", "speed", "seen", "group", "seen_by", "followed_by", "reason")
ROBOTS = ("robot", "x", "y", "deviation", "sees", "follows", "trusted", "reason")
NUMBERS = frozenset({"id", "x", "y", "speed", "seen", "deviation", "sees"})
COUNT_COLUMNS = ("hour", "zone", "people")
SETTINGS_COLUMNS = ("rule", "targets", "followed_at_once", "names", "zones", "history", "retention_hours")
WHOLE_MAP = "(whole map)"


def as_text(seen: Row) -> str:
    """Return the people of a map as plain text."""
    text = io.StringIO()
    text.write(heading(seen) + "\n")
    for columns, rows in _tables(seen):
        if rows:
            text.write("\n" + "\n".join(table(rows, columns)) + "\n")
    return text.getvalue()


def render(seen: Row) -> "Group":
    """Return the people of a map as an object that rich draws."""
    from rich import box  # noqa: PLC0415 - a robot's install has no rich
    from rich.console import Group  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    drawn: list[Any] = [Text(heading(seen), style="bold"), ""]
    for columns, rows in _tables(seen):
        grid = Table(box=box.SIMPLE_HEAD, expand=True, pad_edge=False)
        for column in columns:
            grid.add_column(column, justify="right" if column in NUMBERS else "left", no_wrap=column != "reason")
        for row in rows:
            grid.add_row(*(Text(cell(column, row[column])) for column in columns))
        drawn.append(grid)
    return Group(*drawn)


def heading(seen: Row) -> str:
    """Return the first line: the map, the number of people and the rule; or why there is no coordinator."""
    if seen["coordinator"] != "ready":
        return f"{seen['map']}  no people are tracked: {seen['reason'] or 'the coordinator is starting'}"
    count, following = seen["count"], len(seen["following"])
    people = "person" if count == 1 else "people"
    now = time.strftime("%H:%M:%S", time.localtime(seen["at"]))
    return f"{now}  {seen['map']}  {count} {people}  {following} followed (rule {seen['rule']})"


def counts_for_people(counts: list[Row]) -> list[Row]:
    """Return counts with local times, and a name for the whole map."""
    return [
        count
        | {
            "hour": time.strftime("%Y-%m-%d %H:%M", time.localtime(count["hour"])),
            "zone": count["zone"] or WHOLE_MAP,
        }
        for count in counts
    ]


def _tables(seen: Row) -> list[tuple[tuple[str, ...], list[Row]]]:
    orders = {order["person"]: order for order in seen["following"]}
    follows = {order["robot"]: order["person"] for order in seen["following"]}
    people = [_person(person, orders.get(person["id"]), seen["at"]) for person in seen["people"]]
    robots = [_robot(robot, follows.get(robot["robot"])) for robot in seen["robots"]]
    return [(PEOPLE, people), (ROBOTS, robots)]


def _person(person: Row, order: Row | None, now: float) -> Row:
    x, y = person["position"]
    speed = sum(part**2 for part in person["velocity"]) ** 0.5
    return person | {
        "name": person["name"] or None,
        "x": f"{x:.2f}",
        "y": f"{y:.2f}",
        "speed": f"{speed:.1f}",
        "seen": duration(max(0.0, now - person["last_seen"])),
        "group": person["group"] or None,
        "followed_by": order["robot"] if order else None,
        "reason": order["reason"] if order else None,
    }


def _robot(robot: Row, follows: int | None) -> Row:
    x, y = (None, None) if robot["position"] is None else (f"{place:.2f}" for place in robot["position"])
    deviation = None if robot["deviation"] is None else f"{robot['deviation']:.2f}"
    return robot | {"x": x, "y": y, "deviation": deviation, "follows": follows, "reason": robot["reason"] or None}
