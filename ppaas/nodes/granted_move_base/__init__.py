"""Move Base of a robot that drives as far as the traffic of its map grants."""
