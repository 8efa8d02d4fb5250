"""What can be said of a case before it runs: scene, closed forms, the report of `check`."""
