"""Forward models that we did not write: sections and models, with :mod:`.foreign` below them.

=====================  ======================================
``command``            a program that reads and writes files
``python_function``    a Python function
``umbridge``           a server of the UM-Bridge protocol
=====================  ======================================

What they are made of lies in :mod:`geoswarm.solver.external`; models that an operator registers, in
:mod:`geoswarm.solver.registered`.
"""
