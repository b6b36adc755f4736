"""Commands that publish what was built, each by the program of its registry."""

from pathlib import Path

from ppaas.errors import InvalidInput, NotFound

PARTS = ("wheels", "image", "chart", "page")
"""What is published: packages at an index of Python, image and chart at a registry, files on a page of GitHub."""


def command(part: str, folder: Path, version: str, registry: str, programs: dict[str, str]) -> list[str]:
    """Return the command that publishes one part.

    Parameters
    ----------
    part : str
        One of ``PARTS``.
    folder : Path
        Of what was built.
    version : str
        Released version.
    registry : str
        Host and path of the registry of images, such as ``ghcr.io/owner``.
    programs : dict
        Paths of the programs ``uv``, ``skopeo``, ``helm`` and ``gh``.

    Raises
    ------
    InvalidInput
        The registry is needed and not given.
    NotFound
        A file was not built.
    """
    if part == "wheels":
        files = [_file(folder, f"ppaas_cloud-{version}{end}") for end in (".tar.gz", "-py3-none-any.whl")]
        return [programs["uv"], "publish", "--trusted-publishing", "automatic", *files]
    if part == "page":
        _file(folder, "notes.md")
        files = sorted(str(path) for path in folder.iterdir() if path.name not in ("notes.md", image_name(version)))
        notes = ["--verify-tag", "--title", f"PPaaS {version}", "--notes-file", str(folder / "notes.md")]
        return [programs["gh"], "release", "create", f"v{version}", *notes, *files]
    registry = registry.lower()
    if not registry:
        raise InvalidInput(f"no registry to publish the {part} at: give --registry HOST/OWNER")
    if part == "image":
        archive = _file(folder, image_name(version))
        target = f"docker://{registry}/ppaas-engine:{version}"
        return [programs["skopeo"], "copy", "--preserve-digests", f"oci-archive:{archive}", target]
    return [programs["helm"], "push", _file(folder, f"ppaas-{version}.tgz"), f"oci://{registry}/charts"]


def image_name(version: str) -> str:
    """Return the name of the archive of the image."""
    return f"ppaas-engine-{version}.oci.tar"


def _file(folder: Path, name: str) -> str:
    path = folder / name
    if not path.is_file():
        raise NotFound("file", str(path), advice="build it first")
    return str(path)
