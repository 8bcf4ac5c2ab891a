"""What verification cases and tests are made of: soils by their usual numbers, laboratory tests, simple bodies.

===================  ==============================================================
``soils``            materials of the built-in laws, states of soft soil creep
``laboratory``       sections of laboratory tests, and a short way to run them
``grounds``          sections of layered ground
``bodies``           meshes of rectangles, slopes and stacked blocks
``infinite_slopes``  slopes whose limit is known in closed form
===================  ==============================================================
"""
