"""Jars of the real servers, by Maven: fetched once, into ``build/``, and without the network from then on."""

import hashlib
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.support.sources import ROOT

JARS = ROOT / "build" / "jars"
FETCH_TIMEOUT = 900.0


class Missing(Exception):
    """What a server needs is not on this machine; the text says what to install."""


def java() -> str:
    """Return the Java runtime; ``Missing`` if there is none."""
    found = shutil.which("java")
    if found is None:
        raise Missing("no java: install a Java 17 runtime")
    return found


def keytool() -> str:
    """Return the tool of the Java runtime that makes keys; ``Missing`` if there is none."""
    found = shutil.which("keytool")
    if found is None:
        raise Missing("no keytool: install a Java 17 runtime")
    return found


def jars_of(pom: Path) -> Path:
    """Return a folder with all jars that a project file depends on at run time.

    Raises
    ------
    Missing
        They are not there and Maven is not either, or it cannot fetch them.
    """
    digest = hashlib.sha256(pom.read_bytes()).hexdigest()[:12]
    folder = JARS / f"{pom.parent.name}-{digest}"
    if not folder.is_dir():
        _fetch(pom, folder)
    return folder


def _fetch(pom: Path, folder: Path) -> None:
    maven = shutil.which("mvn")
    if maven is None:
        raise Missing(f"no mvn, and no jars in {folder}: install Maven")
    JARS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".fetching-", dir=JARS) as aside:
        jars = Path(aside) / "jars"
        goal = ["dependency:copy-dependencies", "-DincludeScope=runtime", f"-DoutputDirectory={jars}"]
        command = [maven, "--batch-mode", "--quiet", "--file", str(pom), *goal]
        done = subprocess.run(command, capture_output=True, text=True, timeout=FETCH_TIMEOUT, check=False)
        if done.returncode or not jars.is_dir():
            raise Missing(f"mvn cannot fetch what {pom} lists: {(done.stdout + done.stderr).strip()[:500]}")
        if not folder.exists():  # another may have been faster
            jars.rename(folder)


def main() -> None:
    """Fetch the jars of all servers, which are those of the images; tell what cannot be had."""
    for pom in sorted((ROOT / "docker").glob("*/pom.xml")):
        try:
            print(f"jars of {pom.parent.name}: {jars_of(pom)}")  # noqa: T201
        except Missing as error:
            print(f"jars of {pom.parent.name}: {error}", file=sys.stderr)  # noqa: T201


if __name__ == "__main__":
    main()
