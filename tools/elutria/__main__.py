"""`python -m elutria` is the same as the command `elutria`."""

from elutria.cli import main

if __name__ == "__main__":
    main()
