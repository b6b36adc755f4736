"""Benches of navigation: control cycles of local planners, the BARN worlds, and goals among people."""
