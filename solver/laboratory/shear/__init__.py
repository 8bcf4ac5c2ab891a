"""Tests in which a specimen is sheared.

====================  ===========================================
``triaxial``            the section of the triaxial test
``triaxial_model``      how it is led, and its series
``simple_shear``        the section of the direct simple shear test
``simple_shear_model``  how it is led, and its series
====================  ===========================================
"""
