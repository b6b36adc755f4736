"""Command ``ppaas map``: publishes, imports, lists, shows, changes, compares, merges and deletes maps; zones, tasks."""

import argparse
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.map_files import export_map, import_map, publication
from robots.cli.output import show
from robots.cli.output_files import write_file
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs import map_graphs, map_merge, map_tasks, map_traffic, map_versions, map_zones
from robots.cli.verbs.map_versions import delete_version, diff, list_versions, roll_back, whole_version
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

NAME = "map"
HELP = "publish, import, export, list, show, change, compare, review, merge, roll back and delete maps; zones, tasks"

MAPS = Resource(
    "maps",
    publication.COLUMNS,
    "no maps that you may use; publish one: ppaas map publish FILE.yaml",
    list_columns=("id", "owner", "version", "created", "readers", "description"),
)
ON, OFF = "on", "off"
OCTREES = (".bt", ".ot")
PARTS = ("yaml", "image", "octomap", "posegraph", "zones")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    publish = verbs.add_parser("publish", help="publish a map, or a new version of it")
    _add_publish_arguments(publish)
    listing = verbs.add_parser("list", help="list the maps that you may use")
    one = verbs.add_parser("show", help="show one map")
    change = verbs.add_parser("change", help="change the readers, the description or the traffic of a map")
    versions = verbs.add_parser("versions", help="list the versions of a map with author, time and message")
    diff = verbs.add_parser("diff", help="show the difference between two versions")
    roll_back = verbs.add_parser("roll-back", help="make an earlier version the current one")
    fetch = verbs.add_parser("fetch", help="download the files of a map")
    delete = verbs.add_parser("delete", help="delete a map with all its versions")
    for verb in (one, change, versions, diff, roll_back, fetch, delete):
        verb.add_argument("id")
    _add_diff_arguments(diff)
    roll_back.add_argument("version", help="the version, or a prefix of it")
    roll_back.add_argument("--message", help="reason, stored with the version")
    change.add_argument("--traffic", choices=(ON, OFF), help="whether all robots that connect take part in its traffic")
    publication.add_description_arguments(change)
    for verb in (one, fetch):
        verb.add_argument("--version", help="a version, or a prefix of it (the current one)")
    fetch.add_argument(
        "--to", type=Path, default=Path(), metavar="FOLDER", help="folder for the files (current folder)"
    )
    for verb in (listing, versions):
        add_limit_argument(verb)
    for verb in (publish, listing, one, change, versions, diff, roll_back, fetch, delete):
        add_session_arguments(verb)
    import_map.configure(verbs)
    export_map.configure(verbs)
    map_versions.configure(verbs)
    map_merge.configure(verbs)
    map_tasks.configure(verbs)
    map_traffic.configure(verbs)
    map_zones.configure(verbs)
    map_graphs.configure(verbs)
    _add_version_verbs(verbs.add_parser("version", help="delete a version of a map"))


def _add_diff_arguments(diff: argparse.ArgumentParser) -> None:
    diff.add_argument("old", metavar="A", help="a version, or a prefix of it")
    diff.add_argument("new", metavar="B", nargs="?", help="another version (the current one)")
    diff.add_argument("--plot", type=Path, metavar="FILE.png", help="draw the difference")


def _add_version_verbs(version: argparse.ArgumentParser) -> None:
    delete = version.add_subparsers(dest="version_verb", required=True, metavar="VERB").add_parser(
        "delete", help="delete a version that is not the current one, with its files"
    )
    delete.add_argument("id")
    delete.add_argument("version", help="the version, or a prefix of it")
    add_session_arguments(delete)


def _add_publish_arguments(publish: argparse.ArgumentParser) -> None:
    publish.add_argument(
        "file",
        type=Path,
        help="YAML file of map_server, which names the image; an octomap (.bt, .ot); or a map of MovingAI (.map)",
    )
    publish.add_argument("--octomap", type=Path, metavar="FILE", help="octomap to publish with the image")
    publish.add_argument("--posegraph", type=Path, metavar="FILE", help="pose graph that the image was made of")
    publish.add_argument(
        "--zones", type=Path, metavar="FILE", help="zones on the map, as GeoJSON (those of the current version)"
    )
    publication.add_publication_arguments(publish)
    publish.add_argument(
        "--rules",
        choices=("map_server", "nav2"),
        help="rules for free and occupied pixels (those of the file, or map_server)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _publish(arguments: argparse.Namespace) -> None:
    # Reading YAML needs more than the base install.
    from robots.client.map_files import files_to_publish, map_id_of  # noqa: PLC0415

    file = arguments.file
    only_octomap = file.suffix.lower() in OCTREES
    yaml, image = (None, None) if only_octomap else files_to_publish(file)
    map_id = arguments.id or map_id_of(file)
    octomap = file if only_octomap else arguments.octomap
    await publication.publish(
        arguments, map_id, yaml, image, octomap=octomap, posegraph=arguments.posegraph, zones=arguments.zones,
        rules=arguments.rules,
    )  # fmt: skip


async def _show(arguments: argparse.Namespace) -> None:
    path = path_of("maps", arguments.id, *await _version(arguments))
    show(await logged_in(arguments).get(path), MAPS.columns, as_json=arguments.json)


async def _change(arguments: argparse.Namespace) -> None:
    change: dict[str, Any] = {}
    if arguments.reader is not None:
        change["readers"] = [name for name in arguments.reader if name != publication.NOBODY]
    if arguments.description is not None:
        change["description"] = arguments.description
    if arguments.traffic is not None:
        change["traffic"] = arguments.traffic == ON
    if not change:
        raise InvalidInput("nothing to change; give --reader, --description or --traffic")
    changed = await logged_in(arguments).patch(path_of("maps", arguments.id), change)
    show(changed, MAPS.list_columns, as_json=arguments.json)


async def _fetch(arguments: argparse.Namespace) -> None:
    client, version = logged_in(arguments), await _version(arguments)
    path = ("maps", arguments.id, *version)
    parts = (await client.get(path_of(*path)))["parts"]
    written = await _fetch_parts(client, arguments, path, [part for part in PARTS if part in parts])
    if arguments.json:
        show([str(file) for file in written], (), as_json=True)
    else:
        sys.stdout.writelines(f"{file}\n" for file in written)


async def _fetch_parts(
    client: "RestClient", arguments: argparse.Namespace, path: tuple[str, ...], parts: list[str]
) -> list[Path]:
    from robots.client.map_copies import MapCopies  # noqa: PLC0415 - reading YAML needs more than the base install

    try:
        arguments.to.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".ppaas-fetch-", dir=arguments.to) as folder:
            files = {part: Path(folder) / part for part in parts}
            for part, file in files.items():
                if part == "zones":
                    write_file(file, await map_zones.geojson_of(client, path_of(*path, part)))
                else:
                    await client.fetch_to(path_of(*path, part), file)
            return MapCopies(arguments.to, arguments.id).keep(files)
    except OSError as error:
        raise InvalidInput(f"cannot write to {arguments.to}: {error}") from error


async def _version(arguments: argparse.Namespace) -> tuple[str, ...]:
    version = await whole_version(logged_in(arguments), arguments.id, arguments.version)
    return () if version is None else ("versions", version)


_VERBS = {
    "publish": _publish,
    "import": import_map.import_map_file,
    "from-plan": import_map.from_plan,
    "export": export_map.export,
    "list": MAPS.list,
    "show": _show,
    "change": _change,
    "versions": list_versions,
    "diff": diff,
    "merge": map_merge.merge,
    "roll-back": roll_back,
    "fetch": _fetch,
    "delete": MAPS.delete,
    "version": delete_version,
    "reviews": map_versions.reviews,
    "approve": map_versions.approve,
    "refuse": map_versions.refuse,
    "traffic": map_traffic.traffic,
    "zones": map_zones.zones,
    "import-graph": map_graphs.import_graph,
    "export-graph": map_graphs.export_graph,
    "task": map_tasks.task,
}
