"""What is written for a program before it runs: filled templates, and files of parameters.

===================  ===============================================================================================
``formats``          the formats of placeholders: those of C's printf
``texts``            numbers as other programs read them; files written without changing a byte outside placeholders
``parameter_files``  files of parameters for programs that read them as data: JSON, YAML or CSV
``pest_numbers``     numbers in the parameter spaces of PEST: as many digits as the width takes
``pest_template``    templates of PEST (``.tpl``)
``template``         our own templates: input files of a program with placeholders for numbers
===================  ===============================================================================================
"""
