"""Sketches of tests: the specimen or the ground with what acts on it, and the loading programme.

============  =========================================================================================================
``declared``  what a test says of itself: specimen or ground, loads, drainage, readings, panels
``stages``    panels of a programme from stages of loading
``drawing``   any of these as shapes, and in words
``specimen``  shapes of a specimen in its apparatus
``ground``    shapes of layered ground
``panels``    shapes of a programme
``ticks``     ticks of its axes; lengths as they are usual
``shapes``    lines, areas and texts, and the sheet that they are put on
``svg``       shapes as an element for a page
``marks``     the values beside the line of a loading programme: each where it touches neither a line nor another value
============  =========================================================================================================

A forward model declares its sketch (:meth:`geoswarm.solver.forward.base.ForwardModelSpec.sketch`); the form of the
dashboard shows the element, a report the same shapes.
"""
