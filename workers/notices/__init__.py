"""Tells whoever asked for it that a job has ended: by a signed request to an address of theirs, or by e-mail.

=============  ========================================================================
``settings``   what the operator allows and gives
``addresses``  which addresses a request may go to
``hooks``      whom to tell: made, listed, deleted
``queue``      deliveries in the database: due, held, told, given up
``verdicts``   what the data say about each parameter, found in a process of its own
``message``    what is told
``web``        signed requests
``mail``       e-mail
``notifier``   the thread that delivers
=============  ========================================================================
"""
