"""Kernels: plans cut, told as bytes and read again, many at a time."""
