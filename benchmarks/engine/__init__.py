"""How the engine does: containers that start, crash and are many; machines that are lost; the master; messages."""
