"""Independent solutions that the tests compare linkframe with."""
