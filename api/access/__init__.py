"""Admission to the API: authentication, rate limits, limits of size."""
