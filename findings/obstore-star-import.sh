#!/usr/bin/env bash
# WITH obstore 0.12.1 from PyPI, CPython 3.11 or newer
# EXPECTED every name in __all__ of obstore.store is an attribute of it, as Python's reference asks of a module, so that
#   "from obstore.store import *" binds them.
# SEEN fifteen of the names exist for type checkers only, and the statement raises AttributeError. obstore itself has all
#   of its names.
# HERE Names are imported one by one (storage/backup/repository.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q obstore==0.12.1; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" <<'PYTHON'
import sys

import obstore
import obstore.store

missing = {module.__name__: [name for name in module.__all__ if not hasattr(module, name)]
           for module in (obstore, obstore.store)}
for name, names in missing.items():
    print(f"{name}: {len(names)} names of __all__ are missing: {', '.join(names[:4])}")
try:
    exec("from obstore.store import *")
    raised = ""
except AttributeError as error:
    raised = str(error)
print("from obstore.store import *:", raised or "no error")
sys.exit((len(missing["obstore"]), len(missing["obstore.store"]), bool(raised)) != (0, 15, True))
PYTHON
