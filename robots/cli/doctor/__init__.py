"""Command ``ppaas doctor``."""
