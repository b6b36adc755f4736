#!/usr/bin/env bash
# WITH resvg-py 0.5.0 from PyPI, CPython 3.11 or newer
# EXPECTED a drawing of 210 mm × 100 mm, as Inkscape writes the size of a page, is rendered at 96 pixels per inch, as CSS
#   and resvg's own command define it; help() of svg_to_bytes documents 0 as "SVG default" of its argument dpi.
# SEEN with the default the drawing "has an invalid size", because each millimetre is 0 pixels; lines whose width is in
#   millimetres vanish without an error where the page has pixels. With dpi=96 both are drawn.
# HERE Plans are rendered with dpi=96 (ppaas/imports/maps/drawings/svg.py).
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q resvg-py==0.5.0; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

"$folder/venv/bin/python" <<'PYTHON'
import sys

import resvg_py

HEAD = '<svg xmlns="http://www.w3.org/2000/svg"'
PAGE = f'{HEAD} width="210mm" height="100mm" viewBox="0 0 210 100"><rect width="210" height="100"/></svg>'
LINE = f'{HEAD} width="90" height="90"><path d="M0 45H90" stroke="black" stroke-width="%s"/></svg>'


def drawn(svg, **options):
    try:
        return bytes(resvg_py.svg_to_bytes(svg_string=svg, background="white", **options))
    except ValueError as error:
        return str(error)


page = drawn(PAGE)
print("page of 210 mm:", page if isinstance(page, str) else "drawn")
empty = drawn(LINE % 0)
vanished = drawn(LINE % "5mm") == empty
print("line of 5 mm:", "nothing is drawn" if vanished else "drawn")
right = isinstance(drawn(PAGE, dpi=96.0), bytes) and drawn(LINE % "5mm", dpi=96.0) != empty
print("with dpi=96:", "both are drawn" if right else "not drawn")
sys.exit((isinstance(page, str), vanished, right) != (True, True, True))
PYTHON
