"""Sketches of tests: the specimen, the ground or a section with what acts on it, and the loading programme.

=================  =====================================================================================================
``declared``       what a test says of itself: specimen, ground or section, loads, drainage, readings, panels, phases
``stages``         panels of a programme from stages of loading
``drawing``        any of these as shapes, and in words
``specimen``       shapes of a specimen in its apparatus
``ground``         shapes of layered ground
``section``        shapes of a vertical section: slopes, embankments, excavations
``section_names``  names in a section: in its regions and at its points, interfaces and loads, each where it finds room
``legend``         the legend of a section: what its parts are, a row each
``phases``         shapes of phases: one below the other, with their durations and what each of them changes
``panels``         shapes of a programme
``ticks``          ticks of its axes; lengths as they are usual
``shapes``         lines, areas and texts, and the sheet that they are put on
``svg``            shapes as an element for a page
``marks``          values and names: each where it touches neither a line nor another one
=================  =====================================================================================================

A forward model declares its sketch (:meth:`geoswarm.solver.forward.base.ForwardModelSpec.sketch`); the form of the
dashboard shows the element, a report the same shapes.
"""
