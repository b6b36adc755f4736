"""Metrics of a cloud for Prometheus: what the master knows of it, and the server of scrapes."""
