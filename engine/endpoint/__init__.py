"""Endpoint: the process that serves sockets and REST of a cloud, and calls its master."""
