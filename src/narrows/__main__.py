"""``python -m narrows`` is the command line."""

from narrows.cli.app import main

if __name__ == "__main__":
    main()
