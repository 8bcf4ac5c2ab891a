"""What a residual is, and what it counts.

============  ======================================================================
``distance``  differences of y, or distances of readings from the calculated curve
``loss``      robust losses: what a reading far from the curve counts
============  ======================================================================
"""
