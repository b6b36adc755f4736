"""This project as it is installed: its extras, packages beside it of untried versions, and the origin of plug-ins."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import EntryPoint, PackageNotFoundError, requires, version
from typing import Any

from ppaas.errors import InvalidParameter, Unavailable

NAME = "ppaas-cloud"
"""Name of the distribution; on the index of Python, ``ppaas`` is another program."""

BENCHES = "ppaas-benchmarks"
"""Name of the distribution of the benches, from the same checkout."""

BASE = ""
"""Name of the group of requirements without an extra, which a robot needs."""


class BrokenPlugin(InvalidParameter):
    """An installed plug-in of another distribution cannot be loaded or created; the text names its entry point."""

    slug = "broken-plugin"


def install_hint(*extras: str) -> str:
    """Return the words that explain how to install extras of this project.

    The project is installed from a checkout: no index has it, and a program that an index has under a name like it is
    another one.
    """
    return f"in a checkout of ppaas, pip install '.[{','.join(extras)}]'"


@dataclass(frozen=True, slots=True)
class Requirement:
    """Range of the versions of a package that this project was tried with.

    Parameters
    ----------
    package : str
        Name of its distribution.
    wanted : str
        The range as in ``pyproject.toml``, such as ``>=2,<3``.
    extra : str
        Extra that needs it, or `BASE`.
    """

    package: str
    wanted: str
    extra: str = BASE

    def fits(self, found: str) -> bool:
        """Return whether a version is in the range; of a pre-release, the release that it precedes counts."""
        bounds = re.findall(r"(>=|<)([\d.]+)", self.wanted)
        return all((_release(found) >= _release(bound)) is (sign == ">=") for sign, bound in bounds)


@dataclass(frozen=True, slots=True)
class Misfit:
    """Installed package whose version is outside the range of its requirement."""

    requirement: Requirement
    found: str

    def __str__(self) -> str:
        return f"{self.requirement.package} {self.found} (needed: {self.requirement.wanted})"


def misfits(*groups: str) -> list[Misfit]:
    """Return the installed packages that are older or newer than tried.

    Parameters
    ----------
    *groups : str
        Extras whose packages are checked, or `BASE`. Packages that are not installed are left out.
    """
    needed = [requirement for requirement in _requirements() if requirement.extra in groups]
    found = [Misfit(each, found) for each, found in _installed(needed) if not each.fits(found)]
    return list(
        {each.requirement.package: each for each in found}.values()
    )  # an extra may narrow the range of the base


def pip_command(found: Iterable[Misfit]) -> str:
    """Return the command that installs versions that fit."""
    return " ".join(["pip install", *(f"'{each.requirement.package}{each.requirement.wanted}'" for each in found)])


def check_versions(*groups: str) -> None:
    """Raise ``Unavailable`` if a package of these groups (see `misfits`) is older or newer than tried."""
    found = misfits(*groups)
    if found:
        listed = ", ".join(map(str, found))
        raise Unavailable(f"ppaas does not work with a version that is installed: {listed}; run: {pip_command(found)}")


def read_requirement(line: str) -> Requirement:
    """Read a line of a distribution's metadata (PEP 508), such as ``x[y]<3,>=2; extra == 'cloud'``."""
    head, _, marker = line.partition(";")
    package, bounds = re.fullmatch(r"([\w.-]+)(?:\[[^]]*\])?\s*(.*)", head.strip()).groups()  # type: ignore[union-attr]
    extra = re.search(r"extra\s*==\s*['\"]([\w.-]+)['\"]", marker)
    # Metadata sort the bounds by their sign; people expect the lower one first.
    wanted = ",".join(sorted((bound.strip() for bound in bounds.strip("() ").split(",")), reverse=True))
    return Requirement(package, wanted, extra[1] if extra else BASE)


def _requirements() -> list[Requirement]:
    try:
        return [read_requirement(line) for line in requires(NAME) or ()]
    except PackageNotFoundError:  # imported from a checkout that is not installed
        return []


def _installed(needed: Iterable[Requirement]) -> Iterator[tuple[Requirement, str]]:
    for requirement in needed:
        try:
            yield requirement, version(requirement.package)
        except PackageNotFoundError:
            continue


def _release(text: str) -> tuple[int, ...]:
    """Return the numbers of a release without zeros at its end; without its epoch, which none of ours has."""
    numbers = [int(number) for number in re.match(r"[\d.]*", text)[0].split(".") if number]  # type: ignore[index]
    while numbers and not numbers[-1]:
        numbers.pop()
    return tuple(numbers)


def is_own(entry: EntryPoint) -> bool:
    """Return whether this distribution has an entry point; its plug-ins are always allowed."""
    return entry.dist is not None and entry.dist.name == NAME


def origin(entry: EntryPoint) -> str:
    """Return the entry point and its distribution, for error messages."""
    of = "an unknown distribution" if entry.dist is None else f"{entry.dist.name} {entry.dist.version}"
    return f"entry point {entry.name!r} = {entry.value} of {of}"


def load_entry(entry: EntryPoint, kind: str) -> Any:
    """Return the object of an entry point.

    Parameters
    ----------
    entry : EntryPoint
    kind : str
        Noun for it in errors, such as ``planner``.

    Raises
    ------
    ImportError
        A plug-in of this project needs a package that is not installed.
    BrokenPlugin
        A plug-in of another distribution cannot be imported, for whatever reason.
    """
    try:
        return entry.load()
    except Exception as error:
        if entry.dist is None or entry.dist.name in (NAME, BENCHES):
            raise
        text = f"{kind} {entry.name!r} ({origin(entry)}) cannot be loaded: {type(error).__name__}: {error}"
        raise BrokenPlugin(text) from error
