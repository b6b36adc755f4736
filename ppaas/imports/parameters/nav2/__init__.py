"""Parameter files of Nav2: what becomes of each of its parameters, by node and plug-in."""
