"""Tests of first estimates of parameters."""
