"""The image of a revision as an archive, built by BuildKit with the time of the commit."""

import json
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

from deploy.release.revision import date_of, exported
from ppaas.errors import InvalidInput, Unavailable

DOCKERFILE = "docker/engine.Dockerfile"
NO_DOCKER = "there is no docker with buildx"
BASE = re.compile(r"\S+@sha256:[0-9a-f]{64}")


def resolve(name: str) -> str:
    """Return an image of a registry by the digest that its name has now.

    Raises
    ------
    Unavailable
        No registry that Docker reaches has it.
    """
    words = ["docker", "buildx", "imagetools", "inspect", name, "--format", "{{json .Manifest}}"]
    try:
        done = subprocess.run(words, check=False, capture_output=True, text=True)
    except FileNotFoundError as error:
        raise Unavailable(NO_DOCKER) from error
    if done.returncode:
        raise Unavailable(f"the digest of {name} is not known: {done.stderr.strip()}")
    return f"{name}@{json.loads(done.stdout)['digest']}"


def command(tree: Path, archive: Path, version: str, date: int, arguments: Sequence[str]) -> list[str]:
    """Return the command that builds an image from the files of a revision.

    Parameters
    ----------
    tree : Path
        The files.
    archive : Path
        File to write the image to.
    version : str
        Its version.
    date : int
        Time of all that the build makes [s since 1970].
    arguments : Sequence[str]
        Further ones of ``docker buildx build``.
    """
    labels = {"title": "ppaas-engine", "version": version, "licenses": "Apache-2.0"}
    return [
        *("docker", "buildx", "build", "--file", str(tree / DOCKERFILE)),
        *("--build-arg", f"SOURCE_DATE_EPOCH={date}"),
        *(word for name, value in labels.items() for word in ("--label", f"org.opencontainers.image.{name}={value}")),
        # Attestations of BuildKit have the time of the build. The workflow attests the archive instead.
        *("--provenance=false", "--sbom=false"),
        *("--output", f"type=oci,dest={archive},rewrite-timestamp=true"),
        *arguments,
        str(tree),
    ]


def build(revision: str, archive: Path, version: str, base: str, arguments: Sequence[str] = ()) -> None:
    """Build the image of a revision.

    Parameters
    ----------
    revision : str
        Of the checkout; what is not committed is not in the image.
    archive : Path
        File to write it to.
    version : str
        Its version.
    base : str
        Base image by its digest, ``python:3.11-slim@sha256:…``; a name alone is another image next month.
    arguments : Sequence[str]
        Further ones of ``docker buildx build``.

    Raises
    ------
    InvalidInput
        The base has no digest.
    Unavailable
        There is no such revision or no Docker, or the build failed.
    """
    if not BASE.fullmatch(base):
        raise InvalidInput(f"the base image {base!r} has no digest: give it as NAME@sha256:…")
    archive.parent.mkdir(parents=True, exist_ok=True)
    with exported(revision) as tree:
        words = command(
            tree, archive.resolve(), version, date_of(revision), ("--build-arg", f"PYTHON={base}", *arguments)
        )
        try:
            done = subprocess.run(words, check=False)
        except FileNotFoundError as error:
            raise Unavailable(NO_DOCKER) from error
    if done.returncode:
        raise Unavailable(f"docker buildx ended with status {done.returncode}")
