"""The column as one sees it: frames of a run, live or recorded, on a page or in a film."""
