"""Series from tables.

==============  ================================================
``reader``      the section
``rows``        points from the rows of one table
``blocks``      points from tables that a listing repeats
``quantities``  x and y as columns, or expressions of columns
==============  ================================================
"""
