"""PNG files of matplotlib figures."""

from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput
from robots.pictures.path import check_picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def check_figure(path: Path) -> None:
    """Raise if no figure can be written to a file of this name.

    Commands call it before they compute what they draw.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``.
    ModuleNotFoundError
        Matplotlib is not installed.
    """
    check_picture(path)
    import matplotlib.figure  # noqa: F401, PLC0415 - heavy, and of the extra plot


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure to a PNG file; equal figures give equal bytes.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    check_picture(path)
    try:
        figure.savefig(path, metadata={"Software": None})
    except OSError as error:
        raise InvalidInput(f"cannot write the picture: {error}") from error
