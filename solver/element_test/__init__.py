"""Laboratory tests on one material point under mixed stress and strain control.

==================  ==========================================================================
``setups``          laboratory tests as stages of a material point
``controls``        what is prescribed during a stage
``material_point``  a material point led through stages
``stage_steps``     error-controlled steps through one movement of the controls, or one hold
``mixed_step``      one time step under mixed control
``constant_load``   a history of constant axial loads: the fast path of the laboratory tests
``axial``           one step of a specimen loaded along its axis
==================  ==========================================================================
"""
