"""Wire protocols as sans-I/O state machines: frames in, typed operations out, and back."""
