"""Uncertainty at the optimum: standard errors, intervals, profiles, other basins."""
