"""Commands for the jobs of a service."""
