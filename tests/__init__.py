"""The command line and the notebooks enable float64; so do the tests."""
