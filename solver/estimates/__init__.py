"""First estimates of a problem's parameters: from the readings with a ruler, and from index properties.

====================  ==================================================================
``value``             one value of the readings, or why there is none
``construction``      the lines and points with which it was found, for a figure
``stage_ends``        strain at the ends of the stages of a test
``compression``       Cc, Cs and preconsolidation stress of tests with loads in stages
``load_stages``       c_v and C_alpha of single stages
``constant_rate``     compression curve and c_v of a test at constant rate of strain
``triaxial``          stresses at failure and E50 of triaxial tests
``granular``          hypoplastic sand: h_s and n of the loosest specimen, alpha of peaks, beta of the densest
``reference_stress``  E50_ref of specimens at other stresses, N of Cam clay
``simple_shear``      friction angle and undrained strength of simple shear tests
``classical``         all of these for a problem, for its readings or a calculated curve
``index``             what index properties let expect of the parameters of a problem
``usual``             parameters in their usual ranges, and what laws want between them
``proposal``          parameters of a problem with bounds and estimates from both
``draft``             the same values for a problem that may still have mistakes
====================  ==================================================================
"""
