"""Buildings and navigation graphs of Open-RMF."""
