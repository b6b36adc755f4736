"""Move Base of a robot that follows paths itself."""
