"""The coordinator: the runtime that applies what the pure states decide to the store.

===================  =================================================================================================
``ending``           changes the stop criteria of a job after submission; a job that has ended continues exactly where
                     it was
``generation_rows``  one generation in the transaction that holds the lock of its job: read once, changed in memory,
                     written once
``hand_out``         chooses which evaluations of a generation workers get, in turn, in a transaction that holds the
                     lock of its job
``job_exchange``     one exchange between workers and the coordinator, inside its transaction
``retry``            reruns the failed evaluations of a paused or ended job, without changing the results given to the
                     search
``runtime``          applies events to the store: locks the job's row, calls the pure state machines, writes, commits,
                     and then wakes
``together``         lets threads of one process that make exchanges for the same job at the same time share a
                     transaction
``tries``            effect of a result, a lost worker or a returned claim on one evaluation among the rows of its
                     generation
``work``             messages between a worker and the runtime; how many runs of a job can be in progress at once
===================  =================================================================================================
"""
