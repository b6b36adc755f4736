"""Jars of the real servers: Maven downloads them once to ``build/``; later runs need no network."""

import hashlib
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.support.sources import ROOT

JARS = ROOT / "build" / "jars"
FETCH_TIMEOUT = 900.0

HDFS = ROOT / "docker" / "hdfs" / "pom.xml"
S3, KEYCLOAK = (Path(__file__).with_name(f"{name}.xml") for name in ("s3", "keycloak"))

OTHER_HADOOPS = ("3.5.0",)
"""Versions of Hadoop that the map store is tested with, beside that of the image."""


class Missing(Exception):
    """A requirement of a server is not installed; the message says what to install."""


def java() -> str:
    """Return the path of the Java runtime; ``Missing`` if it is not installed."""
    found = shutil.which("java")
    if found is None:
        raise Missing("no java: install a Java 17 runtime")
    return found


def keytool() -> str:
    """Return the path of Java's keytool; ``Missing`` if it is not installed."""
    found = shutil.which("keytool")
    if found is None:
        raise Missing("no keytool: install a Java 17 runtime")
    return found


def jars_of(pom: Path, **properties: str) -> Path:
    """Return a folder with all jars on which a Maven project file depends at run time.

    Parameters
    ----------
    pom : Path
        The project file.
    **properties : str
        Values of its properties, such as a version, instead of those in the file.

    Raises
    ------
    Missing
        The jars are not there, and Maven is not installed or cannot download them.
    """
    given = [f"-D{name}={value}" for name, value in sorted(properties.items())]
    digest = hashlib.sha256(pom.read_bytes() + "".join(given).encode()).hexdigest()[:12]
    folder = JARS / f"{name_of(pom)}-{digest}"
    if not folder.is_dir():
        _fetch(pom, given, folder)
    return folder


def name_of(pom: Path) -> str:
    """Return the name of the server of a project file: that of the file, or of the folder that has its image."""
    return pom.parent.name if pom.stem == "pom" else pom.stem


def _fetch(pom: Path, given: list[str], folder: Path) -> None:
    maven = shutil.which("mvn")
    if maven is None:
        raise Missing(f"no mvn, and no jars in {folder}: install Maven")
    JARS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".fetching-", dir=JARS) as aside:
        jars = Path(aside) / "jars"
        goal = ["dependency:copy-dependencies", "-DincludeScope=runtime", f"-DoutputDirectory={jars}"]
        command = [maven, "--batch-mode", "--quiet", "--file", str(pom), *given, *goal]
        done = subprocess.run(command, capture_output=True, text=True, timeout=FETCH_TIMEOUT, check=False)
        if done.returncode or not jars.is_dir():
            raise Missing(f"mvn cannot download the dependencies of {pom}: {(done.stdout + done.stderr).strip()[:500]}")
        if not folder.exists():  # another process may have been faster
            jars.rename(folder)


def main() -> None:
    """Download the jars of all servers, those of the images and of other versions; print which are missing."""
    poms = [*sorted((ROOT / "docker").glob("*/pom.xml")), S3, KEYCLOAK]
    wanted: list[tuple[Path, dict[str, str]]] = [(pom, {}) for pom in poms]
    for pom, properties in [*wanted, *((HDFS, {"hadoop": version}) for version in OTHER_HADOOPS)]:
        name = " ".join([name_of(pom), *properties.values()])
        try:
            print(f"jars of {name}: {jars_of(pom, **properties)}")  # noqa: T201
        except Missing as error:
            print(f"jars of {name}: {error}", file=sys.stderr)  # noqa: T201


if __name__ == "__main__":
    main()
