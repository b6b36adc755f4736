"""Options of Python for fork servers: without docstrings, which are a tenth of the memory that containers share.

Modules compiled this way are cached in a folder of our own. If Python's own folder is not writable, or bytecode must
not be written, each start would otherwise compile nine hundred modules again.
"""

import os
import sys
from collections.abc import Mapping

from engine.processes.disk_notes import notes_folder
from engine.runtimes.memory_tuning.switch import LEAN, NAME, OFF

OPTIONS = ("-OO",) if LEAN else ()
PYTHON = (sys.executable, *OPTIONS)

PYTHON_OF_IMAGE = ("python", *OPTIONS) if LEAN else ("env", f"{NAME}={OFF}", "python")
"""Command that starts Python in an image, which has its own environment."""

_FOLDER, _NOWHERE = "PYTHONPYCACHEPREFIX", "PYTHONDONTWRITEBYTECODE"


def environment(given: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the environment of a fork server and its children.

    Parameters
    ----------
    given : mapping
        Environment of this process. A folder for compiled modules that it names is kept.
    """
    if not LEAN:
        return dict(given)
    own = {name: value for name, value in given.items() if name != _NOWHERE}
    return {_FOLDER: str(notes_folder() / "modules"), **own}
