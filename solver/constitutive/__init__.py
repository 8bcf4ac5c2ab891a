"""Kernels of the soil laws in :mod:`geoswarm.solver.laws`: stress, consistent tangent and new state from a strain step.

========================  ==================================================================
``soft_soil_creep``       soft soil creep: parameters and the scalar physics of the model
``creep_update``          one time step of soft soil creep for a general stress
``soft_soil_step``        the same where Mohr-Coulomb flow plays no part, in a plane or general: the fast way
``cam_clay``              one step of modified Cam clay, in a plane or general
``mohr_coulomb``          the Mohr-Coulomb limit with dilatancy and tension cut-off
``general_mohr_coulomb``  one step of elasticity with that limit for a general stress
``planar_mohr_coulomb``   the same in a plane
``smooth_cone``           the limits of Drucker-Prager and Matsuoka-Nakai, and one step of elasticity with them
``principal_return``      what returns on principal axes have in common
``invariants``            invariants of principal stresses with first and second derivatives
``logarithmic``           functions of elasticity that stiffens with pressure
``hardening_surfaces``    surfaces, flow and stiffness of hardening soil
``hardening_return``      the principal stresses of its step
``hardening_soil``        one step of hardening soil, in a plane or general
``hypoplastic_update``    one step of a hypoplastic law by substeps
``hypoplastic_clay``      the functions of hypoplasticity of clay
``hypoplastic_sand``      the functions of hypoplasticity of sand
``intergranular_strain``  intergranular strain along a straight path of strain
``tensors``               symmetric tensors as six components, small dense algebra
========================  ==================================================================
"""
