"""``python -m deploy.release``: check, build, compare and publish a release; the targets of the Makefile call it."""

import argparse
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

from deploy.release import bill, comparison, image, packages, publication, tag
from deploy.release.revision import ROOT, date_of
from ppaas import __version__
from ppaas.distribution import NAME
from ppaas.errors import Conflict, NotFound, PPaaSError

DIST = Path("dist")
BASE = "base-image.txt"
"""File with the base image, by its digest."""
LOCK = ROOT / "deploy" / "requirements.lock"


def _check(arguments: argparse.Namespace) -> str:
    version = tag.check(arguments.tag, ROOT)
    _, text = tag.section((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    (arguments.folder / "notes.md").write_text(f"{text}\n", encoding="utf-8")
    return f"{arguments.tag} may be released"


def _packages(arguments: argparse.Namespace) -> str:
    built = packages.build(arguments.revision, arguments.folder)
    return "\n".join(str(path) for path in built)


def _same(what: str, differences: Iterable[str]) -> str:
    found = list(differences)
    if found:
        raise Conflict("\n".join((f"two builds of {what} differ:", *found)))
    return f"two builds of {what} are equal, byte by byte"


def _reproduce(arguments: argparse.Namespace) -> str:
    with tempfile.TemporaryDirectory(prefix="ppaas-") as one, tempfile.TemporaryDirectory(prefix="other-") as other:
        packages.build_twice(arguments.revision, Path(one), Path(other))
        return _same("the packages", comparison.folder_differences(Path(one), Path(other)))


def _base(arguments: argparse.Namespace) -> str:
    base = image.resolve(arguments.name)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    (arguments.folder / BASE).write_text(f"{base}\n", encoding="utf-8")
    return base


def _base_of(arguments: argparse.Namespace) -> str:
    """Return the base image of a release."""
    path = arguments.folder / BASE
    if not path.is_file():
        raise NotFound("file", str(path), advice="take it from the page of the release, or make base-image")
    return str(path.read_text(encoding="utf-8").strip())


def _archive_of(arguments: argparse.Namespace) -> Path:
    return Path(arguments.folder, publication.image_name(__version__))


def _image(arguments: argparse.Namespace) -> str:
    archive = _archive_of(arguments)
    image.build(arguments.revision, archive, __version__, _base_of(arguments), shlex.split(arguments.buildx))
    return str(archive)


def _digest(arguments: argparse.Namespace) -> str:
    with comparison.ImageArchive(_archive_of(arguments)) as archive:
        return f"digest={archive.digest}"


def _reproduce_image(arguments: argparse.Namespace) -> str:
    words = [*shlex.split(arguments.buildx), "--no-cache"]
    with tempfile.TemporaryDirectory(prefix="ppaas-") as name:
        archives = [Path(name, "first.tar"), Path(name, "second.tar")]
        for archive in archives:
            image.build(arguments.revision, archive, __version__, _base_of(arguments), words)
        return _same("the image", comparison.image_differences(*archives))


def _compare(arguments: argparse.Namespace) -> str:
    return _same("the image", comparison.image_differences(arguments.first, arguments.second))


def _bill(arguments: argparse.Namespace) -> str:
    with comparison.ImageArchive(_archive_of(arguments)) as archive:
        subject = archive.digest
    expected = bill.Expected(bill.pins(LOCK.read_text(encoding="utf-8")), {NAME: __version__}, ("pypi", "deb"))
    count = bill.complete(arguments.file, subject, date_of(arguments.revision), expected)
    return f"{arguments.file}: {count} components of {subject}"


def _publish(arguments: argparse.Namespace) -> str:
    programs = {
        "uv": str(Path(sys.executable).with_name("uv")),
        "helm": str(packages.HELM),
        "skopeo": "skopeo",
        "gh": "gh",
    }
    words = publication.command(arguments.part, arguments.folder, __version__, arguments.registry, programs)
    words += shlex.split(arguments.arguments)
    if arguments.dry_run:
        return shlex.join(words)
    done = subprocess.run(words, check=False)
    if done.returncode:
        raise Conflict(f"{words[0]} ended with status {done.returncode}")
    return f"published: {arguments.part}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("python -m deploy.release", description="Check, build and publish a release.")
    parser.add_argument("--folder", type=Path, default=DIST, help="what was built")
    parser.add_argument("--revision", default="HEAD", help="commit to build")
    verbs = parser.add_subparsers(required=True, metavar="STEP")
    check = verbs.add_parser("check", help="refuse a tag that files do not agree with, and write its notes")
    check.add_argument("tag")
    check.set_defaults(run=_check)
    verbs.add_parser("packages", help="build wheel, source distribution and chart").set_defaults(run=_packages)
    verbs.add_parser("reproduce", help="build the packages twice, and compare them").set_defaults(run=_reproduce)
    base = verbs.add_parser("base", help="note the digest that the base image has now")
    base.add_argument("--name", default="python:3.11-slim", help="of the base image")
    base.set_defaults(run=_base)
    verbs.add_parser("digest", help="print the digest of the image").set_defaults(run=_digest)
    for name, run, what in (
        ("image", _image, "build the image"),
        ("reproduce-image", _reproduce_image, "build the image twice, and compare them"),
    ):
        built = verbs.add_parser(name, help=what)
        built.add_argument("--buildx", default="", help="further arguments of docker buildx build")
        built.set_defaults(run=run)
    compare = verbs.add_parser("compare", help="compare two archives of images")
    compare.add_argument("first", type=Path)
    compare.add_argument("second", type=Path)
    compare.set_defaults(run=_compare)
    checked = verbs.add_parser("bill", help="complete and check the bill of materials of the image")
    checked.add_argument("file", type=Path)
    checked.set_defaults(run=_bill)
    publish = verbs.add_parser("publish", help="publish one part of what was built")
    publish.add_argument("part", choices=publication.PARTS)
    publish.add_argument("--registry", default="", help="registry of images and charts: HOST/OWNER")
    publish.add_argument("--arguments", default="", help="further arguments of the program that publishes")
    publish.add_argument("--dry-run", action="store_true", help="only print the command")
    publish.set_defaults(run=_publish)
    return parser


def main(words: list[str]) -> int:
    """Do one step; return the exit status."""
    arguments = _parser().parse_args(words)
    try:
        text: str = arguments.run(arguments)
    except PPaaSError as error:
        sys.stderr.write(f"release: {error}\n")
        return 1
    sys.stdout.write(f"{text}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
