"""Kernels of the soil laws in :mod:`geoswarm.solver.laws`: stress, consistent tangent and new state from a strain step.

====================  ===============================================================================================
``mohr_coulomb``      elasticity with the Mohr-Coulomb limit, dilatancy and tension cut-off
``smooth_cone``       the limits of Drucker-Prager and Matsuoka-Nakai, and one step of elasticity with them
``hardening_soil``    hardening soil: surfaces and one step
``cam_clay``          one step of modified Cam clay, in a plane or general
``soft_soil_creep``   soft soil creep, and soft soil without creep
``hypoplasticity``    hypoplasticity of clay and sand, with intergranular strain
``principal_return``  what returns on principal axes have in common
``invariants``        invariants of principal stresses with first and second derivatives
``tensors``           symmetric tensors as six components, small dense algebra
``local_arrays``      arrays that live as long as the call of a kernel: memory of its frame, without a request to the
                      system
====================  ===============================================================================================

A model of several files has a folder of its own.
"""
