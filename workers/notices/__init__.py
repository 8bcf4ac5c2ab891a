"""Notifications of jobs that have ended: by a signed request to an address of the user's, or by e-mail.

=============  ========================================================================
``settings``   what the operator allows and gives
``addresses``  which addresses a request may go to
``hooks``      whom to tell: made, listed, deleted
``queue``      deliveries in the database: due, held, told, given up
``verdicts``   what the data say about each parameter, found in a process of its own
``message``    contents of a notification
``web``        signed requests
``mail``       e-mail
``notifier``   the thread that delivers
=============  ========================================================================
"""
