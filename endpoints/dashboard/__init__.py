"""The dashboard: pages that make a browser a client of the cloud, like anybody's."""
