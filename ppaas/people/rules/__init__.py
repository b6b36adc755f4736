"""Rules that choose whom robots follow: plug-ins by entry point."""
