"""Node ``diagnostics``: observes what a robot sends."""
