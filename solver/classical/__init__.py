"""Classical evaluation of laboratory tests: what a ruler on the diagram gives, without a soil law.

====================  =============================================================================================
``curves``            what the evaluations share: the straight line of least squares, and the error of a curve that
                      allows no evaluation
``compression``       Cc and Cs: slopes of the void ratio over the logarithm of stress
``preconsolidation``  preconsolidation stress after Casagrande, and in ln(1 + e)
``consolidation``     c_v by the root and the logarithm of time, and C_alpha
``constant_rate``     c_v and k from a test at constant rate of strain
``mohr_circles``      cohesion and friction angle from stresses at failure
====================  =============================================================================================
"""
