"""The text of a problem: YAML and JSON, read and written."""
