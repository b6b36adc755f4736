"""Process runtime: containers forked from the warm fork server, limited to their size by control groups."""
