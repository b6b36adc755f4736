"""Kernels that are not compiled yet: a container waits for its machine to compile them, or reports that it does so."""
