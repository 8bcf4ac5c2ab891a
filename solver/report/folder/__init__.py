"""The files of ``geoswarm run --output``: written as a run goes, and read again."""
