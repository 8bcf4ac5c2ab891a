"""Laboratory tests on one material point under mixed stress and strain control.

=======================  =======================================================================================
``setups``               laboratory tests as stages of a material point
``specimen``             loads on a specimen as load paths, and strains of laboratories
``boundary_conditions``  what is prescribed during a stage
``material_point``       a material point led through stages
``trace``                the way along several load paths: states at times, and where something is first reached
``load_paths``           the path of a material point along one movement of its controls, or one hold
``advance``              error-controlled steps along a load path
``step_control``         constants of such steps
``column``               coupled consolidation of a column of points
``column_steps``         error-controlled steps of such a column
``consolidation``        a column led through stages
``cells``                its cells
``mixed_step``           one time step under mixed control
``constant_load``        a history of constant axial loads: the fast path of the laboratory tests
``axial``                one step of a specimen loaded along its axis
=======================  =======================================================================================
"""
