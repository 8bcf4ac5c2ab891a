"""Tests in which pore water flows.

=======================  =======================================================================
``crs``                  the section of the oedometer test at constant rate of strain
``crs_model``            its parameters and series
``crs_record``           how a column of points is led through its stages
``consolidation``        the section of the oedometer test in stages with the flow of pore water
``consolidation_model``  how it is calculated, its parameters and series
``load_stages``          its stages of loading, and those of layered ground
=======================  =======================================================================
"""
