"""Layered ground in one dimension with coupled consolidation: sections, drains, calculation and series.

Importable from here: nothing; the forward model is found by its kind, ``column``.
"""
