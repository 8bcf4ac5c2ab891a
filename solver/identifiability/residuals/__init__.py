"""Whether the model describes the data: tests of the residuals.

==================  ==========================================================
``independence``    runs test, Durbin-Watson, repeats
``residual_tests``  patterns in the residuals
``readings``        the readings at the optimum, weighed by their noise
``gross_errors``    readings that the others exclude
``closeness``       how close each quantity comes, over all tests
``lack_of_fit``     all tests as one, with a level of 5 %
``dependence``      noise that is not independent and even
==================  ==========================================================
"""
