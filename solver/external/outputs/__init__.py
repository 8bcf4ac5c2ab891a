"""What is read of a program's files after it ran: readers of series, one a kind of file."""
