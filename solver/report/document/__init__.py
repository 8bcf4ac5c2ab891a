"""The report: its contents, as HTML and PDF.

==================  =======================================================
``build``           :class:`Report`: statistics, figures, HTML and PDF
``content``         what stands in a report, in order
``html``, ``pdf``   its two forms (need the ``plots`` extra)
==================  =======================================================
"""
