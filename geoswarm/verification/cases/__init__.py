"""The cases, a module for each chapter of the manual.

===================  ===============================================================================================
``cam_clay``         modified Cam clay and soft soil: closed forms and quadrature of the rate equations
``consolidation``    consolidation of specimens: loads at once and growing, constant rate of strain
``creep``            soft soil creep: closed forms, independent integration of its rate equations, a published table
``finite_elements``  finite elements: patch test, order of convergence, elastic and creeping bodies, large rotation
``ground``           layered ground: isochrones, two layers, vertical drains, mud under its own weight
``hardening_soil``   hardening soil, with and without small-strain stiffness, against its closed forms
``hypoplasticity``   hypoplasticity of sand and clay: closed forms, published numbers, independent integration
``inference``        statistics and search: intervals, coverage, certified fits, global sensitivity, a known optimum
``limit_loads``      finite elements at the limit: tube, footing, slopes, sliding block
``strength``         strength and dilatancy of the laws that yield: triaxial, plane strain, simple shear, tension
===================  ===============================================================================================
"""
