"""Search methods: ask for a generation, tell its objectives, take a snapshot. They never call an objective."""
