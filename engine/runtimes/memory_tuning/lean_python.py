"""How Python is started for what containers are forked from: documentation left out, a tenth of what they share.

Modules compiled so lie in a folder of our own. Where those of Python itself cannot be written beside it, or nothing may
be, each start would compile nine hundred of them anew.
"""

import os
import sys
from collections.abc import Mapping

from engine.processes.disk_notes import notes_folder

PYTHON = (sys.executable, "-OO")

_FOLDER, _NOWHERE = "PYTHONPYCACHEPREFIX", "PYTHONDONTWRITEBYTECODE"


def environment(given: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return what such a process and its children are to be started with.

    Parameters
    ----------
    given : mapping
        Environment of this process; a folder that it names for compiled modules is kept.
    """
    own = {name: value for name, value in given.items() if name != _NOWHERE}
    return {_FOLDER: str(notes_folder() / "modules"), **own}
