"""The verification manual: cases beside closed forms, independent integration and published numbers.

==============  =====================================================================
``case``        what a case declares, and what it answers
``cases``       the cases, a module for each chapter
``exact``       the closed forms and rate equations that they refer to
``specimens``   soils, laboratory tests and bodies that they are made of
``catalogue``   all cases in the order of the manual
``run``         runs them
``results``     outcomes as rows of words and as JSON
``figure``      ours as lines, the reference as circles
``pages``       the manual as Markdown and HTML
``provenance``  where, when and with what they were run
==============  =====================================================================

Rate equations and bodies are those of the tests, too: a closed form is written once.
"""
