"""Laboratory tests on a material point of any law, as forward models.

======================  =====================================================================
``triaxial``            the section of the triaxial test
``triaxial_model``      how it is led, and its series
``simple_shear``        the section of the direct simple shear test
``simple_shear_model``  how it is led, and its series
``crs``                 the section of the oedometer test at constant rate of strain
``crs_model``           its parameters and series
``crs_record``          how a column of points is led through its stages
``pace``                parts of sections: stages of shearing, how fast they go
``section``             fields that all tests have
``model``               what the forward models of shear tests share
``record``              a calculated test: consolidation, shearing, pore water
``shear_stages``        stages of shearing as legs of a material point
``shear_axes``          what series run over
``series``              how values of a series are picked from a calculated test
``quantities``          what is measured
======================  =====================================================================
"""
