"""What clients ask of jobs: submit and control them, read what they found.

===================  ==================================================================================================
``attachments``      files that people attach to a job: a photo of the specimen, the laboratory's PDF
``bodies``           meshes and displacement fields of jobs: the mesh at once, the fields by one forward run, made once
                     and kept
``findings``         follow-ups of jobs: more evaluations around the optimum or over the whole space, as jobs of their
                     own
``fit``              measured points of a job with what was calculated there, in the units that the user gave
``follow_up_costs``  what the follow-ups of a job would cost, before one is submitted
``job_service``      what the API sees of the engine
``links``            read-only links: keys that show one job to people without a key of their own
``media_types``      what a file that is attached to a job is: decided by its content, never by what the client says
``records``          what a job has found, read from the store: evaluations, generations, events
``statistics``       reports and statistics of jobs from their stored evaluations: no forward run, made once for each
                     state of a job
===================  ==================================================================================================
"""
