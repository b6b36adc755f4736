"""The command line ``ppaas``: finds commands, parses their arguments and prints their answers."""
