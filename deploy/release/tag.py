"""Whether a tag may be released: its version is the one of all files, and CHANGELOG.md documents it with a date."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import yaml
from packaging.version import InvalidVersion, Version

from deploy.release.revision import git
from ppaas.errors import Conflict, InvalidInput, NotFound, Unavailable

HEADING = re.compile(r"^## \[(?P<version>[^\]]+)\] - (?P<date>\S+)$", re.MULTILINE)
DATE = re.compile(r"\d{4}-\d{2}-\d{2}")


def version_of(tag: str) -> str:
    """Return the version that a tag names, as PEP 440 spells it.

    Raises
    ------
    InvalidInput
        The tag is no ``v`` and a version in its normal form.
    """
    text = tag.removeprefix("v")
    try:
        normal = str(Version(text))
    except InvalidVersion:
        normal = ""
    if text == tag or text != normal:
        raise InvalidInput(f"{tag!r} is no tag of a release: v and a version such as v0.2.0")
    return text


def section(changes: str, version: str) -> tuple[str, str]:
    """Return the date and the text that CHANGELOG.md has for a version.

    Raises
    ------
    NotFound
        It has none.
    """
    headings = list(HEADING.finditer(changes))
    for found, following in zip(headings, [*headings[1:], None], strict=True):
        if found["version"] == version:
            end = following.start() if following else len(changes)
            return found["date"], changes[found.end() : end].strip()
    raise NotFound("section of CHANGELOG.md", version)


def file_faults(version: str, root: Path) -> Iterator[str]:
    """Yield what files of a checkout say that does not fit a release of this version."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    chart = yaml.safe_load((root / "deploy" / "helm" / "ppaas" / "Chart.yaml").read_text(encoding="utf-8"))
    for place, found in (
        ("pyproject.toml", project["version"]),
        ("version of Chart.yaml", chart["version"]),
        ("appVersion of Chart.yaml", chart["appVersion"]),
    ):
        if found != version:
            yield f"{place} is {found}, not {version}"
    supported = f"| {'.'.join(version.split('.')[:2])} | yes |"
    if supported not in (root / "SECURITY.md").read_text(encoding="utf-8"):
        yield f"SECURITY.md has no row {supported}"
    try:
        date, text = section((root / "CHANGELOG.md").read_text(encoding="utf-8"), version)
    except NotFound as error:
        yield str(error)
    else:
        if not DATE.fullmatch(date):
            yield f"CHANGELOG.md dates {version} {date!r}, not by a day such as 2026-11-30"
        if not text:
            yield f"the section of {version} in CHANGELOG.md is empty"


def checkout_faults(tag: str) -> Iterator[str]:
    """Yield why the checkout is not what a tag names."""
    try:
        tagged = git("rev-parse", "--verify", "--quiet", f"refs/tags/{tag}^{{commit}}")
    except Unavailable:
        yield f"there is no tag {tag}"
    else:
        if tagged != git("rev-parse", "HEAD"):
            yield f"{tag} is another commit than the one that is checked out"
    changed = git("status", "--porcelain").decode().splitlines()
    if changed:
        yield f"the checkout has {len(changed)} changed files, such as {changed[0][3:]}"


def check(tag: str, root: Path) -> str:
    """Return the version of a tag that may be released.

    Parameters
    ----------
    tag : str
        Such as ``v0.2.0``.
    root : Path
        Checkout of it.

    Raises
    ------
    InvalidInput
        It is no tag of a release.
    Conflict
        Files name another version, or the checkout is another commit; all reasons are given.
    """
    version = version_of(tag)
    faults = [*file_faults(version, root), *checkout_faults(tag)]
    if faults:
        raise Conflict(f"{tag} cannot be released: {'; '.join(faults)}")
    return version
