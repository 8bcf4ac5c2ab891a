"""Commands for programs as forward models: ``geoswarm model new`` and ``geoswarm model try``.

===================  ==================================================================================================
``group``            ``geoswarm model``: programs of your own as forward models; ``geoswarm model build-umat``
``imports``          ``geoswarm import``: problems made of the files of other tools
``new``              ``geoswarm model new``: a first problem file for a program, with a template made of an example of
                     its input
``registered``       ``geoswarm models``: the models that are registered on this machine
``trial``            ``geoswarm model try``: one run of a program, with what was written and the lines that each number
                     was read from
``umbridge``         ``geoswarm umbridge``: the forward model of a problem for clients of UM-Bridge
``umbridge_server``  the forward model of a problem behind the UM-Bridge protocol 1.0: a small HTTP server of Python's
                     own library
===================  ==================================================================================================
"""
