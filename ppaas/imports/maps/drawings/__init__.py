"""Floor plans: pictures, SVG, DXF and pages of PDF, whose scale two points give."""
