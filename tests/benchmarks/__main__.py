"""Run the benchmark: `python -m tests.benchmarks`, or `make bench`."""

if __name__ == "__main__":
    # Only here: every process that a measurement gets to itself imports this module, and some must not meet HiGHS.
    from tests.benchmarks.cli import main

    main()
