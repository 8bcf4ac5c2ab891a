"""Laboratory tests on one material point under mixed stress and strain control.

==================  ==========================================================================
``setups``          laboratory tests as stages of a material point
``controls``        what is prescribed during a stage
``material_point``  a material point led through stages
``mixed_step``      one time step under mixed control, and its error-controlled sequence
``constant_load``   a history of constant axial loads: the fast path of the laboratory tests
``axial``           one step of a specimen loaded along its axis
==================  ==========================================================================
"""
