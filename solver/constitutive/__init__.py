"""Material laws as pure functions compiled by Numba: stress, consistent tangent and new state from a strain step.

======================  ====================================================================
``elastic``             linear isotropic elasticity
``soft_soil_creep``     soft soil creep: parameters and the scalar physics of the model
``creep_update``        one time step of soft soil creep for a general stress
``mohr_coulomb``        the Mohr-Coulomb limit with dilatancy and tension cut-off
``tensors``             symmetric tensors as six components, small dense algebra
======================  ====================================================================
"""
