"""Upkeep and health of a service: sweeps, retention, probes, metrics."""
