"""The mathematics of geoswarm; runs with no server, no network and no database.

=======================  ===============================================================================================
``problem``              what a user asks for: models of the problem file, reading, units
``plausibility``         what in a problem is probably not meant
``forward``              forward models behind one protocol, found through entry points
``laws``                 soil laws behind one binary interface
``constitutive``         their kernels: stress, tangent, new state
``element_test``         one material point under mixed stress and strain control
``fem``                  finite elements in the plane: meshes, phases, strength, creep
``kernels``              how kernels are compiled, and where they are kept; ``warm`` has all of them compiled
``expressions``          formulas that users write
``objective``            misfits f'_g and objective f of the responses
``methods``              the methods of a problem file: one module each, found through entry points
``search``               ask / tell / snapshot: particle swarm, differential evolution, Monte Carlo sampling
``calibration``          assembles a problem into what a search and an evaluation need
``runner``               forward calculations in processes that can be killed
``runs``                 the in-process loop, the reference for the distributed engine; a try before
``identifiability``      what the data can tell: verdicts, uncertainty
``report``               figures, tables and reports
``residuals``            what a residual is and what it counts: distances, robust losses
``sentences``            sentences that name keys of the problem, which each surface words
``words``                numbers, durations and states as a reader sees them
``ags``                  files of ground investigations in the AGS 4 format: what a laboratory delivers, as a problem
``answering``            the runs after a search that its result needs: begun when it ends, each follow-up planned from
                         those before
``arrays``               array types used throughout the solver, and arrays as bytes
``column``               layered ground in one dimension with coupled consolidation: sections, drains, calculation and
                         series
``course``               the course of a calibration from generation to generation; pure
``declared_parameter``   a parameter that a user declares: of a registered model, or of a soil law in a library
``errors``               everything that can go wrong in the solver
``examples``             the examples: problem files with their data, from a wheel or from a source tree
``external``             what a forward model that is a program of the user's is made of
``index_properties``     index properties of a soil, as laboratories report them
``laboratory``           laboratory tests on any law, as forward models: at a material point, or a column of points in
                         which water flows
``parameter_info``       one parameter of a calculation, as its users see it
``parameter_estimates``  first estimates of parameters: from readings with a ruler, and from index properties
``progress``             where a calibration stands: its state between generations, when it stops, and what it returns
``registered``           models that the operator of a service registers: a folder with ``model.yaml`` and files of a
                         program
``section``              what all sections of a problem file have in common
``sketches``             sketches of tests: the specimen or the ground with what acts on it, and the loading programme
``system``               what the solver needs of the system below it
``units``                units at the door: factors between the units that users write and the base units of series (kN,
                         m, day, degree)
``user_laws``            soil laws in libraries of the user's
``warm``                 compile numerical kernels ahead of the first calibration: ``python -m geoswarm.solver.warm``
=======================  ===============================================================================================
"""

from __future__ import annotations

if __name__ != "geoswarm.solver":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.solver: solver is a part of geoswarm and has no name of its own")
