"""Temporary folders of processes that may be killed, and files in folders that other users can write to."""
