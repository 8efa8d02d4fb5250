"""Chapters of the verification book: each module has NAME, TITLE, HELP and SECTIONS."""
