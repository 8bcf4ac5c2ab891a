"""Laboratory tests on any law, as forward models: at a material point, or a column of points in which water flows.

=======================  =================================================================================
``triaxial``             the section of the triaxial test
``triaxial_model``       how it is led, and its series
``simple_shear``         the section of the direct simple shear test
``simple_shear_model``   how it is led, and its series
``crs``                  the section of the oedometer test at constant rate of strain
``crs_model``            its parameters and series
``crs_record``           how a column of points is led through its stages
``consolidation``        the section of the oedometer test in stages with the flow of pore water
``consolidation_model``  how it is calculated, its parameters and series
``load_stages``          its stages of loading, and those of layered ground
``water_flow``           the permeability, and what is measured of a column of points
``pace``                 parts of sections: stages of shearing, how fast they go
``section``              fields that all tests have, and those with flow
``model``                what the forward models of all tests share, of tests with flow, and of shear tests
``record``               a calculated test: consolidation, shearing, pore water
``shear_stages``         stages of shearing as legs of a material point
``shear_axes``           what series run over
``series``               how values of a series are picked from a calculated test
``quantities``           what is measured
=======================  =================================================================================
"""
