"""``python -m ahrs_rs``: the command line."""

from ahrs_rs.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
