"""Agents: workers without the database, that reach the service by HTTP. What is given to them, and what they bring."""
