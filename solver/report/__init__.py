"""Figures, tables and reports from results.

===============  =====================================================================================================
``record``       contents of a report, wherever the run was
``curves``       measured and calculated series in the units that the user gave; which points of long ones are drawn
``laboratory``   parameters as laboratories know them; ``compression`` the tests that they are read from
``uncertainty``  what follow-ups and a posterior sample have found
``jsonable``     any of these as JSON
``folder``       the files of ``geoswarm run --output``, written and read again
``figures``      one module a figure (matplotlib), palette and sizes
``document``     contents of a report, as HTML and PDF (need the ``plots`` extra)
``parts``        which parts of a report can be left out
``compared``     another set of parameters, such as a published one, beside the result of a run
``compression``  the compression curve of a laboratory test: void ratio, or strain, at the ends of the stages over log
                 stress
``diagrams``     measured and calculated values of the diagrams that tests declare: one series over another
``overlays``     several tests in one diagram: the curves of all that have the same axes, measured and calculated
``questions``    starting point of follow-ups, from the report of a run: parameters with all that is known about them
``terms``        identified parameters of any law in the laboratory's terms, as the law declares them
===============  =====================================================================================================
"""
