"""Xacro files, expanded to URDF without ROS."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from xml.dom import DOMException
from xml.parsers.expat import ExpatError

from ppaas.errors import InvalidInput

ENDING = ".xacro"

_IN_USE = re.compile(rb"<xacro:|\$\{|\$\(")
_FAULTS = (InvalidInput, OSError, RuntimeError, ValueError, TypeError, LookupError, ArithmeticError)
"""What expressions of a file, and files that are not of xacro, raise."""

_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")


def is_xacro(path: Path, data: bytes) -> bool:
    """Return whether a file is one of xacro, by its ending or by what is left to expand."""
    return path.suffix == ENDING or (b"xmlns:xacro" in data and _IN_USE.search(data) is not None)


def expand_xacro(path: Path, folders: Sequence[Path], arguments: Mapping[str, str]) -> bytes:
    """Return the URDF that a xacro file expands to.

    Parameters
    ----------
    path : Path
    folders : sequence of Path
        Folders of packages, for ``$(find NAME)``: a package is a folder of its name, or with its ``package.xml``.
    arguments : mapping of str to str
        Arguments of the file, for ``$(arg NAME)``.

    Raises
    ------
    InvalidInput
        The file, or one that it includes, cannot be read or expanded; the text names the part.
    """
    import xacro  # noqa: PLC0415 - of the extra imports
    from xacro.substitution_args import SubstitutionException  # noqa: PLC0415

    faults = (xacro.XacroException, SubstitutionException, ExpatError, DOMException, *_FAULTS)
    with _packages_in(folders):
        try:
            xacro.init_stacks(str(path))
            document = xacro.parse(None, str(path))
            xacro.process_doc(document, mappings=dict(arguments), verbosity=0)
        except faults as error:
            raise InvalidInput(f"cannot expand {path}: {_words(getattr(error, 'exc', None) or error)}") from error
    expanded: bytes = document.toxml(encoding="utf-8")
    return expanded


def _words(error: BaseException) -> str:
    if isinstance(error, RecursionError):
        return "a macro or a property contains itself"
    if type(error).__name__ == "ArgException":
        return f"the argument {error} has no value; give one: --xacro-arg {error}=VALUE"
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def _packages_in(folders: Sequence[Path]) -> Iterator[None]:
    """Find packages in folders while a file is expanded: xacro asks an index that is there with ROS only."""
    from xacro import substitution_args  # noqa: PLC0415

    usual = substitution_args._eval_find
    substitution_args._eval_find = lambda name: str(_package(name, folders))
    try:
        yield
    finally:
        substitution_args._eval_find = usual


def _package(name: str, folders: Sequence[Path]) -> Path:
    for folder in folders:
        for candidate in (folder / name, folder):
            if candidate.is_dir() and (candidate.name == name or _declares(candidate, name)):
                return candidate.resolve()
    raise InvalidInput(f"the package of $(find {name}) is in no folder known; name its folder by --mesh-folder FOLDER")


def _declares(folder: Path, name: str) -> bool:
    """Return whether a folder is a package of a name by its manifest."""
    try:
        found = _NAME.search((folder / "package.xml").read_text("utf-8"))
    except (OSError, UnicodeDecodeError):
        return False
    return found is not None and found[1] == name
