"""Where workers live: embedded beside the API, or in Celery's processes."""
