"""What clients ask of jobs: submit and control them, read what they found."""
