"""What is read of a program's files after it ran: readers of series, one a kind of file.

================  ============================================================================================
``series``        which reader a section asks for
``base``          what all readers have in common
``tables``        tables, also repeated in a listing
``pest``          instruction files of PEST
``mesh``          results on meshes, sampled at points
``hdf5_reader``   series from HDF5 files
``json_paths``    places in a JSON document: ``results.time``, ``results[*].uy``, ``steps[-1]["total force"]``
``json_reader``   series from JSON files
``lines``         files of text, line by line: a file of any size is never held as a whole
``numbers``       numbers as programs write them, those of Fortran included
``numpy_reader``  series from files of NumPy: ``.npy`` with columns, ``.npz`` with named arrays
``fields``        file names and regular expressions that users write
``search``        series from lines that match a regular expression
================  ============================================================================================
"""
