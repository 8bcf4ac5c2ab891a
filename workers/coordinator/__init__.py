"""The coordinator: pure state machines, and the runtime that applies them to the store."""
