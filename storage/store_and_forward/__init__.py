"""Store and forward in front of a remote store: plans wait on the disk while the store is unreachable."""
