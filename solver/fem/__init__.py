"""Finite elements: six-node triangles and interfaces under phases of loading and creep.

Tension is positive here; stress and strain have the components xx, yy, zz, xy (engineering shear strain), with z the
circumference in axisymmetry (x radius, y height). Units kN, m, day. A calculation is a mesh, phases, and one call::

    from geoswarm.solver.fem.materials import InterfaceMaterial, Material
    from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
    from geoswarm.solver.fem.solve import solve_phases
    from geoswarm.solver.laws.registry import find_law

    rock = Material(find_law("elastic").soil({"E": 1e4, "nu": 0.3}), unit_weight=20.0)
    clay = Material(find_law("soft_soil_creep").soil({"lambda_star": 0.1, ...}), unit_weight=18.0)

    fixed = (Fixity("bottom", x=0.0, y=0.0), Fixity("left", x=0.0), Fixity("right", x=0.0))
    results = solve_phases(
        mesh,
        [
            Phase("weight", "gravity", materials={"soil": rock}, fixities=fixed),
            Phase("creep", "creep", materials={"soil": clay}, duration=365.0,
                  updated_mesh=True, reset_displacements=True, output_times=(0.0, 100.0, 365.0)),
        ],
        geometry="plane_strain",
        observe=("A", "B"),
    )
    results[-1].history.displacements      # (times, points, 2) of the observed points
    results[-1].displacements              # (nodes, 2) at the end; .stress, .internal, .interface_tractions, .positions

It raises :class:`geoswarm.solver.errors.DivergedError` with the phase, how far it came and why, when it cannot go on.

================  ======================================================================================================
``mesh``          meshes: structured sections, meshes of other programs, output
``materials``     materials as phases assign them
``phases``        what happens, phase by phase
``solve``         the calculation
``results``       what comes out
``body``          what the kernels know of a body in one phase, and its state
``edges``         surface tractions as nodal forces: on the mesh as it is, or following it
``initial``       initial stresses at rest, and the initial state of a soil where it is placed
``interface``     zero-thickness interfaces of three node pairs: forces of contact and friction, integrated at the pairs
                  (1:4:1)
``multifrontal``  LU factorisation front by front without pivoting, and the solution with the factors
``newton``        one step to equilibrium by Newton's method, full or modified
``ordering``      the order of elimination: nested dissection of the elements, and the tree of frontal matrices that
                  follows from it
``setup``         from a mesh and a phase to the arrays of the kernels: materials, fixities, loads
``stepping``      steps of load and of time through one phase, with cutting where a step fails and growth where it is
                  easy
``strength``      a change of strength in steps, from what the old stresses need down to what the new materials have
``triangle``      six-node triangles: internal forces and their exact derivative
================  ======================================================================================================
"""
