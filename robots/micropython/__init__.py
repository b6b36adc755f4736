"""Client of a robot with MicroPython: one file, which is copied to the board."""
