"""How Python is started for what containers are forked from: documentation left out, a tenth of what they share.

Modules compiled so lie in a folder of our own. Where those of Python itself cannot be written beside it, or nothing may
be, each start would compile nine hundred of them anew.
"""

import os
import sys
from collections.abc import Mapping

from engine.processes.disk_notes import notes_folder
from engine.runtimes.memory_tuning.switch import LEAN, NAME, OFF

OPTIONS = ("-OO",) if LEAN else ()
PYTHON = (sys.executable, *OPTIONS)

PYTHON_OF_IMAGE = ("python", *OPTIONS) if LEAN else ("env", f"{NAME}={OFF}", "python")
"""How it is started in an image, which has an environment of its own."""

_FOLDER, _NOWHERE = "PYTHONPYCACHEPREFIX", "PYTHONDONTWRITEBYTECODE"


def environment(given: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return what such a process and its children are to be started with.

    Parameters
    ----------
    given : mapping
        Environment of this process; a folder that it names for compiled modules is kept.
    """
    if not LEAN:
        return dict(given)
    own = {name: value for name, value in given.items() if name != _NOWHERE}
    return {_FOLDER: str(notes_folder() / "modules"), **own}
