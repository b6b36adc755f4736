"""Maps of other programs: vacuum robots and mowers, point clouds, GIS rasters and floor plans, as maps of ours."""
