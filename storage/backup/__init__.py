"""Backups: all records and maps of a cloud in a repository of content-addressed blocks, and their restoration."""
