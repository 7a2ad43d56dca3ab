"""`python -m waypointctl` is `waypointctl`."""

from waypointctl.cli.main import main

if __name__ == "__main__":
    main()
