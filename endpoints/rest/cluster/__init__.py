"""REST resources of the cluster: machines, containers and health."""
