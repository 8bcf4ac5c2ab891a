"""The agent: its parts, each by itself."""
