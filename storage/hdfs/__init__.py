"""TODO storage/hdfs."""
