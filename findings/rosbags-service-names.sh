#!/usr/bin/env bash
# WITH rosbags 0.11.9 from PyPI, Python 3.10 or newer
# EXPECTED get_types_from_msg returns the request of a service under the name that is given, as it does for messages
#   (package/msg/Name) and for parts of actions (package/action/Name_Goal).
# SEEN package/srv/Name_Request comes back as package/srv/msg/Name_Request; the type is then not found under its own name.
# HERE Definitions are parsed under a placeholder and named afterwards (ppaas/wire/ros/values.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q rosbags==0.11.9; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" <<'PYTHON'
import sys

from rosbags.typesys import get_types_from_msg

NAMES = ("std_msgs/msg/Note", "acme_msgs/action/Clean_Goal", "acme_msgs/srv/Clean_Request")
found = [next(iter(get_types_from_msg("string[] rooms", name))) for name in NAMES]
print("; ".join(f"{name} is returned as {one}" for name, one in zip(NAMES, found, strict=True)))
sys.exit(found != [*NAMES[:2], "acme_msgs/srv/msg/Clean_Request"])
PYTHON
