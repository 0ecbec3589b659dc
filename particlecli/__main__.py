"""Entry point of the command `particlecli` and of `python -m particlecli`."""

from particlecli.cli.app import main

if __name__ == "__main__":
    main()
