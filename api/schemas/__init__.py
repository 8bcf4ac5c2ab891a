"""What goes over HTTP, as OpenAPI tells it."""
