"""Series from what instruction files of PEST read.

================  ===================================
``reader``        the section
``instructions``  instruction files, parsed
``follow``        reads a file after them
================  ===================================
"""
