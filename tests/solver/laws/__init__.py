"""Soil laws."""
