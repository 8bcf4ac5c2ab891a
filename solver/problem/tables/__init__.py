"""Measurements from tables: CSV, workbooks, pasted cells.

================  ======================================================================================================
``alterations``   what makes the numbers of a column another quantity than the unit beside it says: factors, sums,
                  functions
``blocks``        where a table begins in the rows of a file: below titles and preambles, with its headings and their
                  units
``cells``         the cells of a file of measurements, CSV, XLSX or ODS: what problem files, the command line and the
                  form all read
``columns``       measured points from the columns of a file: by heading or by cells, with the units of headings and
                  dates as days
``dates``         dates and times of day in the cells of a table, as programs and laboratories write them
``headings``      the units that headings, units rows and comments of a file of measurements name, German or English
``measurements``  looks into files of measurements before they become observations: columns, numbers, probable units and
                  meaning
``numerals``      numbers as people write them: the sign before decimals, that between thousands, and where either may
                  be meant
``opendocument``  the cells of an OpenDocument workbook (ODS): values as they are stored, no formulas are calculated
``packed``        the parts of a packed workbook (XLSX, ODS): unpacked no further than is safe, without document types
``picking``       which cells of a sheet a column of measurements is: by heading, by letter (B:B), by range (B5:B30) or
                  by name
``quantities``    what a column holds, from the words of its heading, German or English, as laboratories write them
``reading``       the text of tables: comma, semicolon, tab or blanks between cells, ``#`` comments, decimal comma or
                  point
``remarks``       what a file says beside its readings: factors, offsets and units, and notes between the rows
``unit_words``    the words for units that laboratories write, German and English
``workbooks``     reads the cells of a spreadsheet (XLSX, ODS): values as they are stored, no formulas are calculated
================  ======================================================================================================
"""
