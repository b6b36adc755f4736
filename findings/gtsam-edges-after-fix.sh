#!/usr/bin/env bash
# WITH gtsam 4.3.0 and g2opy 2.3.0 from PyPI, Python 3.11 or newer
# EXPECTED readG2o returns all edges of a file of g2o wherever its line FIX stands; the order of lines has no meaning in
#   the format, and g2o itself loads such a file whole.
# SEEN gtsam reads edges up to the first line with a tag that it does not know, such as FIX or PARAMS_SE2OFFSET. If that
#   line stands between vertices and edges, it returns all poses and no edge, without an error. gtsam 4.2 read all.
# HERE FIX is written after the edges (ppaas/mapping/graph/g2o.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q gtsam==4.3.0 g2opy==2.3.0; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

vertices=$'VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n'
edge=$'EDGE_SE2 0 1 1 0 0 100 0 0 100 0 100\n'
printf '%sFIX 0\n%s' "$vertices" "$edge" >"$folder/before.g2o"
printf '%s%sFIX 0\n' "$vertices" "$edge" >"$folder/after.g2o"

"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys
from pathlib import Path

import g2opy
import gtsam


def edges(name: str) -> tuple[int, int]:
    """Return the number of edges that gtsam and g2o read from a file."""
    path = str(Path(sys.argv[1]) / name)
    graph = g2opy.SparseOptimizer()
    graph.load(path)
    return gtsam.readG2o(path)[0].size(), len(graph.edges())


before, after = edges("before.g2o"), edges("after.g2o")
print(f"edges that gtsam and g2o read: {before} of 1 with FIX before the edge, {after} with FIX after it")
sys.exit((before, after) != ((0, 1), (1, 1)))
PYTHON
