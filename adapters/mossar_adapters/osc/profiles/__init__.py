"""The ways in which programs send skeletons over OSC, one module for each."""
