"""Tools of all processes: process names, socket folders, background tasks, heartbeats and notes on disk."""
