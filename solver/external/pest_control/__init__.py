"""Control files of PEST and PEST++ as problem files.

================  ==================================================================
``case``          what a control file says, as far as a problem can say it
``reading``       reads one, with pyEMU (extra ``pest``)
``sections``      other contents of a control file: reported, never silently dropped
``command_line``  its command line, split without a shell
``names``         names that a problem accepts
``parameters``    transformations, bounds, ties, SCALE and OFFSET
``series``        observations by instruction file and group, and their x
``files``         templates, instruction files and files of the program
``problem``       the text of the problem file
================  ==================================================================
"""
