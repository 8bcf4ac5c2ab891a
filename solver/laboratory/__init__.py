"""Laboratory tests on any law, as forward models: at a material point, or a column of points in which water flows.

=================  =================================================================================================
``shear``          triaxial test and direct simple shear test
``flow``           oedometer tests with the flow of pore water: at constant rate of strain, and in stages
``section``        fields that all tests have, and those with flow
``pace``           parts of sections: stages of shearing, how fast they go
``model``          what the forward models of all tests share, of tests with flow, and of shear tests
``record``         a calculated test: consolidation, shearing, pore water
``shear_stages``   stages of shearing as load paths of a material point, and how they are drawn
``shear_axes``     what series run over
``series``         how values of a series are picked from a calculated test
``quantities``     what is measured
``water_flow``     the permeability, and what is measured of a column of points
=================  =================================================================================================
"""
