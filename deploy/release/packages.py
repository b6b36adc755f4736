"""Wheel, source distribution and chart of a revision: the same bytes wherever and whenever they are built."""

import gzip
import io
import os
import shutil
import subprocess
import sys
import tarfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from deploy.release.revision import ROOT, date_of, exported
from ppaas.errors import Unavailable

HELM = ROOT / "build" / "helm" / "helm"
"""The program, as ``make helm`` fetches it."""


@dataclass(frozen=True)
class Surroundings:
    """What differs between two computers that build the same.

    Parameters
    ----------
    environment : Mapping[str, str]
        Variables.
    umask : int
        Rights that new files do not have.
    touched : bool
        Files were changed now, as in a fresh checkout, instead of at the time of their commit.
    """

    environment: Mapping[str, str] = field(default_factory=dict)
    umask: int = 0o022
    touched: bool = False


HERE = Surroundings()
ELSEWHERE = Surroundings({"TZ": "Pacific/Kiritimati", "PYTHONHASHSEED": "1", "LC_ALL": "C.UTF-8"}, 0o077, touched=True)
"""Far from the surroundings of most computers."""


def run(words: list[str], folder: Path, around: Surroundings, date: int) -> None:
    """Run a program that builds something.

    Raises
    ------
    Unavailable
        It is not there, or it failed.
    """
    environment = os.environ | around.environment | {"SOURCE_DATE_EPOCH": str(date)}
    try:
        done = subprocess.run(
            words, cwd=folder, env=environment, umask=around.umask, check=False, capture_output=True, text=True
        )
    except FileNotFoundError as error:
        raise Unavailable(f"there is no {words[0]}: {error.strerror}") from error
    if done.returncode:
        raise Unavailable(f"{' '.join(words)} failed:\n{(done.stdout + done.stderr).strip()}")


def build(revision: str, folder: Path, around: Surroundings = HERE) -> list[Path]:
    """Build the source distribution of a revision, the wheel from it, and the chart.

    Parameters
    ----------
    revision : str
        Of the checkout; what is not committed is not in them.
    folder : Path
        Folder to put them in, which is made.
    around : Surroundings
        Of the build.

    Returns
    -------
    list of Path
        The three files.

    Raises
    ------
    Unavailable
        There is no such revision or no Helm, or a build failed.
    """
    date = date_of(revision)
    folder.mkdir(parents=True, exist_ok=True)
    with exported(revision) as tree:
        if around.touched:
            for path in sorted(tree.rglob("*")):
                os.utime(path, follow_symlinks=False)
        sdist = _hatchling("sdist", tree, folder, around, date)
        chart = _chart(tree, folder, around, date)
        inner = tree / "unpacked"
        with tarfile.open(sdist) as archive:
            archive.extractall(inner, filter="data")
        [project] = inner.iterdir()
        return [sdist, _hatchling("wheel", project, folder, around, date), chart]


def _hatchling(target: str, project: Path, folder: Path, around: Surroundings, date: int) -> Path:
    out = project / "built"
    run(
        [sys.executable, "-m", "hatchling", "build", "--target", target, "--directory", str(out)], project, around, date
    )
    [built] = out.iterdir()
    return Path(shutil.move(built, folder / built.name))


def _chart(tree: Path, folder: Path, around: Surroundings, date: int) -> Path:
    out = tree / "packed"
    out.mkdir()
    run([str(HELM), "package", "deploy/helm/ppaas", "--destination", str(out)], tree, around, date)
    [packed] = out.iterdir()
    target = folder / packed.name
    target.write_bytes(_dated(packed.read_bytes(), date))
    return target


def _dated(packed: bytes, date: int) -> bytes:
    """Return an archive of Helm, which has the time of its packing, with another time."""
    written = io.BytesIO()
    with (
        tarfile.open(fileobj=io.BytesIO(packed), mode="r:gz") as before,
        gzip.GzipFile(filename="", fileobj=written, mode="wb", mtime=date) as compressed,
        tarfile.open(fileobj=compressed, mode="w") as after,
    ):
        for member in sorted(before.getmembers(), key=lambda found: found.name):
            member.mtime, member.mode = date, 0o644
            after.addfile(member, before.extractfile(member))
    return written.getvalue()


def build_twice(revision: str, first: Path, second: Path) -> None:
    """Build a revision in two folders, in different surroundings and at different times."""
    build(revision, first, HERE)
    time.sleep(2.0)  # the resolution of times in a wheel
    build(revision, second, ELSEWHERE)
