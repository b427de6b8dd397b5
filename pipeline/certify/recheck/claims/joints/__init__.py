"""What is verified of joints."""
