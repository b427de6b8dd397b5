"""What is verified of a certificate: one module per claim, each apart from the code that searches for the proof."""
