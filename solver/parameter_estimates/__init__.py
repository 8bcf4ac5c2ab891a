"""Estimates of a problem's parameters: from the readings with a ruler, and from index properties.

=======================  =============================================================================================
``values``               one value or why there is none, what was drawn to find it, and the straight line
``compression_curve``    Cc, Cs and preconsolidation stress of a curve, after Casagrande and in ln(1 + e)
``consolidation_curve``  c_v by the root and the logarithm of time, and C_alpha of a curve
``mohr_circles``         cohesion and friction angle from stresses at failure
``correlations``         published correlations of index properties
``observed_curves``      curves of a test, and strain at the ends of its stages
``compression``          Cc, Cs and preconsolidation stress of tests with loads in stages
``consolidation``        c_v and C_alpha of single stages
``constant_rate``        compression curve, c_v and k of a test at constant rate of strain
``shear``                strength, E50 and dilatancy of triaxial and direct simple shear tests
``law_parameters``       hypoplastic sand, moduli of hardening soil at p_ref, N of clays
``classical``            all evaluations of a problem, for its readings or a calculated curve
``index``                what index properties let expect of the parameters of a problem
``proposal``             parameters of a problem, or a draft, with bounds and estimates from both
=======================  =============================================================================================

The first five know numbers only: no soil law, no problem.
"""
