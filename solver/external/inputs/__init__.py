"""What is written for a program before it runs: filled templates, and files of parameters."""
