"""Maps as immutable files with a log of versions for each map, on a local disk or any other."""
