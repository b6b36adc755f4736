"""Page of the examples: the files of docs/examples, by folder."""

from pathlib import Path, PurePosixPath

from docs.site.reference.markdown import page as joined
from docs.site.reference.markdown import slug

ROOT = Path(__file__).resolve().parents[3]
FOLDER = PurePosixPath("docs/examples")


def files() -> list[PurePosixPath]:
    """Return the files of the examples, from the root of the project, without READMEs: a page would be made of each."""
    every = (file for file in (ROOT / FOLDER).rglob("*") if file.is_file() and "__pycache__" not in file.parts)
    found = (file for file in every if file.name != "README.md")
    return [PurePosixPath(file.relative_to(ROOT).as_posix()) for file in sorted(found)]


def anchor(folder: PurePosixPath) -> str:
    """Return the anchor of a folder on the page."""
    return slug(folder.as_posix())


def page() -> str:
    """Return the page."""
    parts = ["# Examples", "Files that the other pages use, to download; they lie in these folders of a checkout."]
    found = files()
    for folder in dict.fromkeys(file.parent for file in found):
        names = [f"- [{file.name}](../files/{file})" for file in found if file.parent == folder]
        parts += [f"## `{folder}`", "\n".join(names)]
    return joined(*parts)
