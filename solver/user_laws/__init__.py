"""Soil laws in libraries of the user's.

==================  ==========================================================================
``section``         what their sections in a problem have in common; expressions of parameters
``law``             what their laws have in common
``umat``            the section and law of a compiled Abaqus user routine
``build``           compiles Fortran sources of such routines; ``fortran`` holds what is linked with them
``library``         opens libraries
``material``        a law by name, or one of these sections, in a forward model
==================  ==========================================================================

The thin functions around the routines, which are compiled, are in :mod:`geoswarm.solver.laws.libraries`.
"""
