"""The command line as ``python -m wmr_ctrl``, where no script is on the path."""

from wmr_ctrl.cli import main

if __name__ == "__main__":
    main()
