"""The coordinator: the runtime that applies what the pure states decide to the store."""
