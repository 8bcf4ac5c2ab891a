"""Hardening soil: shear surface and cap.

======================  ========================================
``surfaces``            parameters, surfaces, flow and stiffness
``principal_stresses``  the principal stresses of a step
``step``                one step, in a plane or general
``small_strain``        stiffness over the history of strain
``small_strain_step``   one step with small-strain stiffness
======================  ========================================
"""
