"""Files of maps for other programs: point clouds and GeoTIFF."""
