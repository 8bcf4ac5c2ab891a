"""Tests of published correlations."""
