"""Statistics of stored evaluations, and what follows from them.

======================  ===============================================================================================
``study``               all of these in one go
``filtering``           threshold of good fits, given or proposed
``correlations``        Pearson and Spearman with confidence intervals
``projections``         the objective over each parameter, and what follows from its shape
``verdicts``            identified, bounded on one side, in combination, not identified
``proposals``           fix, link, widen, add a test; as changes of the problem file
``surface``             response surface over stored evaluations, checked by hold-out
``slices``               slices and contours of the objective through the best run, from the response surface
``linearised``          sensitivities from stored evaluations
``posterior``           posterior sample through a checked response surface
``global_sensitivity``  Sobol and Morris indices (extra ``statistics``)
``findings``            what the jobs of sensitivities, profiles and designs tell
``exploring``           where runs are spent that look for a second basin: what the stored ones exclude the least
``follow_ups``          the problems of follow-ups: the problem of a job with another ``method``
``stored_fit``          whether the model describes the data, from stored evaluations alone: no forward calculation, no
                        derivatives
``verdict_words``       verdicts in words: the reason in one clause, and the sentence, from the record of a verdict
======================  ===============================================================================================
"""
