"""Measurements from tables: CSV, workbooks, pasted cells."""
