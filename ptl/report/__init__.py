"""Presentation of results: tables, figures, pages and the explorer."""
