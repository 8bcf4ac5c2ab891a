"""What is read from and written to the tables; all take the connection of the caller's transaction.

===============  =======================================================================================================
``agents``       queries on agents, and on what they hold
``api_keys``     queries on API keys
``attachments``  queries on files that are attached to jobs
``evaluations``  queries on evaluations
``follow_ups``   which follow-ups a job has, and the evaluations of one in their order
``job_list``     the list of jobs: filtered, searched, sorted, in pages that miss and repeat no job while others are
                 submitted
``jobs``         queries on jobs, their generations and events
``listing``      listings of evaluations that answer at once however long the history is; cursors of their pages
``offers``       runs that earlier jobs offer to a job: found when it is submitted, stored with it, read when it starts
``progress``     progress of the current generation, the time of runs, and workers free for more
``queue``        the lines in which jobs wait for workers: one for each owner, served in turn
``selection``    which part of a long history its statistics read: whole generations, so that they are found at once
``versions``     under which versions a job's evaluations were made: those it was begun under, then every other set that
                 took part
``views``        turns rows into records
``workers``      queries on worker processes
``sessions``     queries on the sessions of browsers
===============  =======================================================================================================
"""
