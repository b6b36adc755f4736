"""Traffic of the robots of a map: grants to drive, which keep robots out of each other's way."""
