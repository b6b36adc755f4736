"""Processes: names, socket folders, background tasks, heartbeats and notes on disk, which every process uses."""
