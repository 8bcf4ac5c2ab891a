"""What keeps a service in order and tells how it is: sweeps, retention, probes, measures."""
