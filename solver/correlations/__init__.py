"""Published correlations: what index properties of a soil let expect of its compressibility, strength and stiffness.

====================  ==========================================================================
``properties``        index properties of a soil
``section``           the same as a section of a problem
``correlation``       one correlation: equation, source, range of validity, scatter
``compressibility``   Cc, Cs, C_alpha and C_k
``strength``          friction angle, K0 and undrained strength
``relative_density``  stiffness and strength of sand by its relative density; limits of its void ratio
``catalogue``         all of them, and what they say about one soil
====================  ==========================================================================
"""
