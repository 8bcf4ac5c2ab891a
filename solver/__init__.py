"""The mathematics of geoswarm; runs with no server, no network and no database.

==================  ==========================================================================
``problem``         what a user asks for: models of the problem file, reading, units
``plausibility``    what in a problem is probably not meant
``forward``         forward models behind one protocol, found through entry points
``laws``            soil laws behind one binary interface
``constitutive``    their kernels: stress, tangent, new state
``element_test``    one material point under mixed stress and strain control
``fem``             finite elements in the plane: meshes, phases, strength, creep
``kernels``         how kernels are compiled, and where they are kept; ``warm`` has all of them compiled
``expressions``     formulas that users write
``objective``       misfits f'_g and objective f of the responses
``methods``         the methods of a problem file: one module each, found through entry points
``search``          ask / tell / snapshot: particle swarm, differential evolution, Monte Carlo sampling
``stopping``        stop criteria
``calibration``     assembles a problem into what a search and an evaluation need
``runner``          forward calculations in processes that can be killed
``runs``            the in-process loop, the reference for the distributed engine; a try before
``identifiability`` what the data can tell: verdicts, uncertainty
``report``          figures, tables and reports
``words``           numbers, durations and states as a reader sees them
==================  ==========================================================================
"""

from __future__ import annotations

if __name__ != "geoswarm.solver":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.solver: solver is a part of geoswarm and has no name of its own")
