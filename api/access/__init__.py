"""The door of the API: who comes in, how often, how much at once."""
