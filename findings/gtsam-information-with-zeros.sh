#!/usr/bin/env bash
# WITH gtsam 4.3.0 and g2opy 2.3.0 from PyPI, Python 3.11 or newer
# EXPECTED readG2o reads an edge that measures only a position, whose information has a zero for the angle; the matrix is
#   positive semidefinite, and g2o itself loads and optimizes such an edge.
# SEEN gtsam raises "load2D::readNoiseModel looks like this is not G2O matrix order": it guesses the order of the six
#   numbers by which of them are zero. A weight of 1e-9 instead of 0 is read.
# HERE information is read and written as it is (ppaas/mapping/graph/g2o.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q gtsam==4.3.0 g2opy==2.3.0; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" - "$folder" <<'PYTHON'
import sys
from pathlib import Path

import g2opy
import gtsam


def edges(angle: str) -> tuple[int, int]:
    """Return the number of edges that gtsam and g2o read, of one with this weight of its angle."""
    path = Path(sys.argv[1]) / "graph.g2o"
    path.write_text(f"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 100 0 0 100 0 {angle}\n")
    graph = g2opy.SparseOptimizer()
    graph.load(str(path))
    try:
        return gtsam.readG2o(str(path))[0].size(), len(graph.edges())
    except RuntimeError as error:
        print(f"gtsam: {error}")
        return 0, len(graph.edges())


none, little = edges("0"), edges("1e-9")
print(f"edges that gtsam and g2o read: {none} of 1 with a weight of 0 for the angle, {little} with 1e-9")
sys.exit((none, little) != ((0, 1), (1, 1)))
PYTHON
