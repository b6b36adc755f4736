"""REST resources of robots: their files, models, URDFs, and where their nodes run."""
