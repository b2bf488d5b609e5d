"""`python -m porous_swim`."""

from porous_swim.commands.cli import main

if __name__ == "__main__":
    main()
