"""What is claimed of the controlled poses themselves."""
