"""Processes of a cloud that serve sockets and REST: their settings, their main function, and their keeper."""
