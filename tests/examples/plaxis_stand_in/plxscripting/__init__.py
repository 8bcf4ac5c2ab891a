"""Stand-in for the client of PLAXIS: the few calls that run_plaxis.py makes, written from its public manual."""
