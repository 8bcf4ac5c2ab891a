"""Models that the operator of a service registers: a folder with ``model.yaml`` and the files of a program.

===============  =====================================================================================================
``spec``         the section of the problem file
``declaration``  ``model.yaml``: the model, its parameters, its settings
``settings``     values of a few types that users may choose
``folders``      where registered models are found, and what version they are
``model``        the forward model
``schema``       what forms need to know
``signed``       the signed list of registered models that a service hands out: which files each consists of, and that
                 it is genuine
===============  =====================================================================================================
"""
