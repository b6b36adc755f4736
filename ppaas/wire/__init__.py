"""Wire protocols as sans-I/O state machines, which convert between frames and typed operations."""
