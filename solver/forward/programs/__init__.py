"""Forward models that we did not write: sections and models, with :mod:`.foreign` below them.

===================  ==========================================================================================
``command``          a program that reads and writes files
``python_function``  a Python function
``umbridge``         a server of the UM-Bridge protocol
``command_model``    the forward model that a program is: one run of it for each evaluation
``foreign``          common parts of forward models that we did not write: only their declared series are known
``python_model``     the forward model that a Python function is: one call of it for each evaluation
``umbridge_model``   the forward model that a server is: one request for each evaluation
===================  ==========================================================================================

Their parts are in :mod:`geoswarm.solver.external`; models that an operator registers, in
:mod:`geoswarm.solver.registered`.
"""
