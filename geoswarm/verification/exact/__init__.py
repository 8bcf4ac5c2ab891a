"""Closed forms, and rate equations as their papers print them: nothing here calls the code that it verifies.

=====================  =============================================================================
``consolidation``      series of Terzaghi, Olson, Wissa and others, Gray; flow to a drain
``creep``              soft soil creep: rates, an oedometer stage, isotropic stages
``cam_clay``           modified Cam clay: undrained path, drained strains by quadrature
``hardening_soil``     the hyperbola, Rowe's dilatancy, the curve of Hardin and Drnevich
``hypoplastic_rates``  tensors of the papers and their integration
``hypoplasticity``     limiting void ratios; strength of cones and of Mohr-Coulomb in several planes
``nist``               certified fits of the Statistical Reference Datasets
=====================  =============================================================================
"""
