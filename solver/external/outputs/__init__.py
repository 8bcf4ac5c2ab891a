"""What is read of a program's files after it ran: readers of series, one a kind of file.

===================================  =======================================================
``series``                           which reader a section asks for
``base``                             what all readers have in common
``lines``, ``numbers``, ``paths``    files of text, numbers as programs write them, names of files
``tables``                           tables, also repeated in a listing
``search``, ``patterns``             lines that match a regular expression
``pest``                             instruction files of PEST
``json_reader``, ``json_paths``      JSON
``numpy_reader``, ``hdf5_reader``    arrays
``mesh``                             results on meshes, sampled at points
===================================  =======================================================
"""
