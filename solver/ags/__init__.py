"""Files of ground investigations in the AGS 4 format: what a laboratory delivers, as a problem.

AGS Data Format, edition 4 (Association of Geotechnical and Geoenvironmental Specialists): lines of quoted cells, in
groups of which each has headings, units and types before its data.

==================  ==================================================================
``tables``          groups, their cells as text, numbers and moments; errors by line
``reading``         reads a file
``specimens``       which specimen a row belongs to, and its name
``consolidation``   CONG/CONS and ESCG/ESCT: void ratios at the ends of increments
``shear_strength``  TREG/TRET and TRIG/TRIT: stresses at failure
``moments``         dates and times in the form that a column states
``monitoring``      MONG/MOND: readings of instruments over time
``contents``        all of them in one file, and the choice among them
``parameters``      sections of a law's parameters
``parts``           one test of a problem, and its readings
``oedometer``       the section and the readings of a compression test
``triaxial``        those of a shear test
``wishes``          what a file does not say
``document``        the problem and what was assumed, with points for a form
``problem``         the problem file and the files beside it
==================  ==================================================================
"""
