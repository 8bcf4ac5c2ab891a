"""A table of laboratory tests, one row a test, which becomes the parts and observations of a combined problem.

=============  ===========================================================================================
``expansion``  a document with a table of tests made one with parts and observations
``readings``   the readings of a test: columns of its file found by their headings, loads from readings
``rows``       the rows of a table, with the words of their headings and cells understood
``section``    the sections of the problem file: a row, and a table with what all its rows share
=============  ===========================================================================================
"""
