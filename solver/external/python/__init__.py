"""A Python function as a forward model.

=============  =================================================================================================
``signature``  which parameters a function has: from its source, or from itself
``loading``    imports the file of a function, by path, under a name of its own; keeps functions of this process
``failures``   what is said of an exception: the lines of the user's file only
``answers``    what a function returned, as responses at the observed points
=============  =================================================================================================
"""
