"""Stores by URL: a scheme names a backend, which is imported only when it is opened."""
