"""The way down to a minimum, and the points that its surroundings are told by.

===============  ===============================================================
``descent``      Levenberg-Marquardt, one generation an iteration
``differences``  where to evaluate for derivatives
``planned``      sensitivities, profiles and designs of global sensitivity
``chains``       one side of a profile
===============  ===============================================================
"""
