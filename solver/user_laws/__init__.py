"""Soil laws in libraries of the user's.

==================  ==============================================================================================
``section``         what their sections in a problem have in common; expressions of parameters
``law``             what their laws have in common
``umat``            the section and law of a compiled Abaqus user routine
``build``           compiles Fortran sources of such routines; ``fortran`` holds what is linked with them
``library``         opens libraries
``material``        a law by name, or one of these sections, in a forward model
``behaviour``       what a library says of a behaviour of MFront: properties with their limits, state variables,
                    hypotheses
``mfront``          ``law: mfront``: a behaviour of MFront in a library as a soil law
``read_behaviour``  reads what a library says of a behaviour of MFront: a program of its own, as opening a library
                    executes parts of it
==================  ==============================================================================================

The thin functions around the routines, which are compiled, are in :mod:`geoswarm.solver.laws.libraries`.
"""
