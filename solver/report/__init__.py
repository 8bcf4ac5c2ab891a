"""Figures, tables and reports from results.

==================  ====================================================================
``build``           :class:`Report`: statistics, figures, HTML and PDF of one run
``record``          what a report tells of a run, wherever it was
``folder``          a run from the files of ``geoswarm run --output``
``run_folder``      those files, written as a run goes, and what a run that was cut off goes on from
``curves``          measured and calculated series in the units that the user gave
``tables``          result, evaluations and generations as JSON and CSV files
``uncertainty*``    what follow-ups and a posterior sample have found
``content``         what stands in a report, in order
``html``, ``pdf``   its two forms (need the ``plots`` extra)
``figures``         the figures of a run by name
``*_plot``          one module a figure (matplotlib, without a display and its global state)
``style``           palette, sizes, files
==================  ====================================================================
"""
