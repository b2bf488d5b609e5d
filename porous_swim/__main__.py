"""`python -m porous_swim`."""

from porous_swim.cli import main

if __name__ == "__main__":
    main()
