"""Runtimes: start and watch the processes of containers, without knowledge of their messages."""
