"""Runtimes: what starts and watches the processes of containers, and knows nothing of their messages."""
