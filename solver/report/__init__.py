"""Figures, tables and reports from results.

==================  ====================================================================
``record``          what a report tells of a run, wherever it was
``curves``          measured and calculated series in the units that the user gave
``laboratory``      parameters as laboratories know them; ``compression`` the tests that they are read from
``thinning``        which points of long series are drawn
``uncertainty``     what follow-ups and a posterior sample have found
``jsonable``        any of these as JSON
``folder``          the files of ``geoswarm run --output``, written and read again
``figures``         one module a figure (matplotlib), palette and sizes
``document``        what stands in a report, as HTML and PDF (need the ``plots`` extra)
==================  ====================================================================
"""
