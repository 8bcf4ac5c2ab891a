"""What jobs and evaluations are and become: pure functions, without a database."""
