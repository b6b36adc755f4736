"""Command ``ppaas task``: runs the tasks of a mission file, or rehearses them and prints a time table."""

import argparse
import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, Unavailable
from robots.cli import event_loop
from robots.cli.output import print_line, show
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.tasks.floors import needed_floors, stations_on
from robots.cli.tasks.places import stations_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.tasks.records import Task
    from ppaas.tasks.timetable import TimeTableRow
    from robots.client.rest import RestClient

NAME = "task"
HELP = "run the tasks of a mission file on a map, or rehearse them and print a time table"

COLUMNS = ("task", "robot", "set_out", "begin", "finish", "waits", "state", "late", "reason")
ON_FLOORS = (*COLUMNS[:2], "floors", *COLUMNS[2:])
ADDED = ("task", "id", "state")
POLL = 1.0
"""Interval of queries while a command waits for the end of a mission [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = "'ppaas map task' adds, lists, shows, confirms and cancels single tasks."
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    run_mission = verbs.add_parser("run", help="add the tasks of a mission file, or rehearse them with --dry-run")
    run_mission.add_argument("file", type=Path, metavar="FILE.json", help="mission; ppaas task schema prints its form")
    run_mission.add_argument("--dry-run", action="store_true", help="add nothing; print a time table of a rehearsal")
    run_mission.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the time table as a Gantt chart")
    run_mission.add_argument(
        "--wait", action="store_true", help="wait for the end of all; exit with 1 unless all are done"
    )
    run_mission.add_argument(
        "--confirmed-after",
        type=float,
        default=60.0,
        metavar="SECONDS",
        help="in a rehearsal, time of a confirmation (60)",
    )
    add_session_arguments(run_mission)
    verbs.add_parser("schema", help="print the JSON schema of mission files")


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    if arguments.verb == "schema":
        from ppaas.tasks.mission import schema  # noqa: PLC0415 - ``ppaas --help`` loads this module

        print_line(json.dumps(schema(), indent=2))
    else:
        event_loop.run(_run(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    from ppaas.tasks.mission import mission_in, tasks_of  # noqa: PLC0415 - as above

    if arguments.picture is not None:
        from robots.pictures.figure_file import check_figure  # noqa: PLC0415 - as above

        check_figure(arguments.picture)
        if not arguments.dry_run and not arguments.wait:
            raise InvalidInput("--picture needs --dry-run or --wait: it shows tasks that have ended")
    client, start = logged_in(arguments), time.time()
    mission = mission_in(_content(arguments.file))
    floors = await needed_floors(client, mission.map, mission.floors)
    stations, others = await stations_of(client, mission.map), await stations_on(client, floors, mission.floors)
    home = "" if floors is None else floors.home
    tasks = tasks_of(mission, stations, start, home=home, others=others)
    if arguments.dry_run:
        from robots.cli.tasks.rehearsal import rehearse  # noqa: PLC0415 - as above

        found = await rehearse(client, mission.map, tasks, start, arguments.confirmed_after, floors=floors)
        _print(list(found.values()), start, arguments)
    else:
        await _add(client, mission.map, tasks, start, arguments)


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the mission {file}: {error.strerror or error}") from error


async def _add(
    client: "RestClient", map_id: str, tasks: "list[Task]", start: float, arguments: argparse.Namespace
) -> None:
    from asyncio import sleep  # noqa: PLC0415 - as above

    from robots.cli.tasks.rehearsal import request_of, task_of  # noqa: PLC0415 - as above

    path = path_of("maps", map_id, "tasks")
    added: dict[str, dict[str, Any]] = {}
    for task in tasks:
        ids = {name: str(one["id"]) for name, one in added.items()}
        added[task.id] = await client.post(path, request_of(task, ids))
    if not arguments.wait:
        rows = [{"task": name, **answer} for name, answer in added.items()]
        show(rows, ADDED, as_json=arguments.json)
        return
    while any(one["ended"] is None for one in added.values()):
        await sleep(POLL)
        for name, one in added.items():
            if one["ended"] is None:
                added[name] = await client.get(f"{path}/{one['id']}")
    ended = [task_of(one | {"id": name}) for name, one in added.items()]
    _print(ended, start, arguments)
    missed = [task.id for task in ended if task.state != "done"]
    if missed:
        raise Unavailable(f"{len(missed)} of {len(ended)} tasks are not done: {', '.join(missed[:10])}")


def _print(tasks: "list[Task]", start: float, arguments: argparse.Namespace) -> None:
    from msgspec import to_builtins  # noqa: PLC0415 - as above

    from ppaas.tasks.timetable import time_table  # noqa: PLC0415 - as above

    rows = time_table(tasks, start)
    columns = ON_FLOORS if any(row.floors for row in rows) else COLUMNS
    show([_rounded(to_builtins(row)) for row in rows], columns, as_json=arguments.json)
    if not arguments.json:
        print_line(_summary(rows))
    if arguments.picture is not None:
        from robots.pictures.gantt import write_gantt  # noqa: PLC0415 - as above

        write_gantt(arguments.picture, arguments.file.stem, rows)


def _rounded(row: dict[str, Any]) -> dict[str, Any]:
    return {name: round(value, 1) if isinstance(value, float) else value for name, value in row.items()}


def _summary(rows: "list[TimeTableRow]") -> str:
    done = [row for row in rows if row.state == "done"]
    end = max((row.finish or 0.0 for row in done), default=0.0)
    late, robots = sum(row.late for row in rows), len({row.robot for row in done})
    return f"{len(done)} of {len(rows)} tasks done by {robots} robots in {end:.0f} s, {late} late"
