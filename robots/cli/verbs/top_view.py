"""Views of ``ppaas top``: tables for a terminal, and plain text."""

import io
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from robots.cli.output import cell, duration, percent, size, table

if TYPE_CHECKING:
    from rich.console import Group

Row = dict[str, Any]

MACHINES = ("id", "state", "cores", "capacity", "load", "memory_used", "memory", "containers", "kernels")
CONTAINERS = (
    "id", "kind", "user", "robot", "map", "machine", "state", "connected", "cores", "cpu", "pss", "age", "clients",
)  # fmt: skip
NUMBERS = frozenset(MACHINES[2:] + CONTAINERS[8:])


SORT_KEYS: dict[str, Callable[[Row], Any]] = {
    "cpu": lambda row: -(row["cpu"] or 0.0),
    "memory": lambda row: -(row["pss"] or 0),
    "age": lambda row: -row["age"],
    "robot": lambda row: (row["robot"] or "", row["user"]),
    "id": lambda row: (len(row["id"]), row["id"]),
}


def as_text(seen: Row, sort: str) -> str:
    """Return the view as plain text."""
    text = io.StringIO()
    text.write(heading(seen) + "\n")
    for columns, rows in _tables(seen, sort):
        if rows:
            text.write("\n" + "\n".join(table(rows, columns)) + "\n")
    return text.getvalue()


def render(seen: Row, sort: str) -> "Group":
    """Return the view as an object that rich draws."""
    from rich import box  # noqa: PLC0415 - a robot's install has no rich
    from rich.console import Group  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    drawn: list[Any] = [Text(heading(seen), style="bold"), ""]
    for columns, rows in _tables(seen, sort):
        grid = Table(box=box.SIMPLE_HEAD, expand=True, pad_edge=False)
        for column in columns:
            grid.add_column(column, justify="right" if column in NUMBERS else "left", no_wrap=True)
        for row in rows:
            grid.add_row(*(Text(cell(column, row.get(column))) for column in columns))
        drawn.append(grid)
    return Group(*drawn)


def heading(seen: Row) -> str:
    """Return the first line: the time and the totals."""
    containers = seen["containers"]
    robots = sum(one["connected"] for one in containers)
    cpu, memory = (sum(one[key] or 0 for one in containers) for key in ("cpu", "pss"))
    oldest = max((one["age"] for one in containers), default=0.0)
    return (
        f"{time.strftime('%H:%M:%S', time.localtime(seen['time']))}  {robots} robots connected  "
        f"{len(containers)} containers  CPU {percent(cpu)}  memory {size(memory)}  oldest {duration(oldest)}"
    )


def _tables(seen: Row, sort: str) -> list[tuple[tuple[str, ...], list[Row]]]:
    containers = sorted(seen["containers"], key=SORT_KEYS[sort])
    return [(MACHINES, seen["machines"] or []), (CONTAINERS, containers)]
