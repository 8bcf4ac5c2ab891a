"""The distributed engine: store, coordinator, worker processes and the service that the API sees."""
