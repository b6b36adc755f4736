"""Process runtime: containers forked from the warm fork server, held to their size by control groups."""
