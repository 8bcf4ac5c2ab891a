"""What a forward model that is a program of the user's is made of.

=================  ==================================================================================================
``inputs``         what is written before a run: templates, files of parameters
``runs``           folder, process, success and failure of a run
``outputs``        what is read after a run: tables, instructions, meshes
``python``         functions of files: arguments, import, what they return
``interpolation``  from the points of a program to those that were observed
``trial``          a run that is looked at closely
``copies``         files on their way into a folder, where nothing is overwritten
``errors``         what can go wrong around the files of a program
``pest_control``   control files of PEST and PEST++ as problem files
``umbridge``       models behind the UM-Bridge protocol 1.0: the client's side
``reading_time``   limits the time for reading the output of a run: a regular expression can take forever on a line
=================  ==================================================================================================
"""
