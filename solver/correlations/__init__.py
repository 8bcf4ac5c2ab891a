"""Published correlations: what index properties of a soil let expect of its compressibility, strength and stiffness.

====================  =================================================================================================
``properties``        index properties of a soil
``section``           the same as a section of a problem
``correlation``       one correlation: equation, source, range of validity, scatter
``compressibility``   Cc, Cs, C_alpha and C_k
``catalogue``         strength, stress at rest, sand by its relative density; all correlations, and what they say about
                      one soil
====================  =================================================================================================
"""
