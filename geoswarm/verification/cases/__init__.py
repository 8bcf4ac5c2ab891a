"""The cases, a module for each chapter of the manual."""
