"""Permissions and limits: API keys, sign-ins, quotas."""
