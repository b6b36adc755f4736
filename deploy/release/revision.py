"""A revision of git, from which everything of a release is built: its files and its time."""

import io
import subprocess
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ppaas.errors import Unavailable

ROOT = Path(__file__).resolve().parents[2]
"""The checkout."""


def git(*words: str) -> bytes:
    """Run git in the checkout; return what it prints.

    Raises
    ------
    Unavailable
        git refuses: there is no such revision or no checkout.
    """
    done = subprocess.run(("git", *words), cwd=ROOT, check=False, capture_output=True)
    if done.returncode:
        raise Unavailable(f"git {' '.join(words)}: {done.stderr.decode(errors='replace').strip()}")
    return done.stdout


def date_of(revision: str) -> int:
    """Return the time of a commit [s since 1970], the SOURCE_DATE_EPOCH of its builds."""
    return int(git("log", "-1", "--format=%ct", revision, "--"))


@contextmanager
def exported(revision: str) -> Iterator[Path]:
    """Unpack the files of a revision in a new folder, which is deleted at the end."""
    packed = git("archive", "--format=tar", revision)
    with tempfile.TemporaryDirectory(prefix="ppaas-release-") as name:
        with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(name, filter="data")
        yield Path(name)
