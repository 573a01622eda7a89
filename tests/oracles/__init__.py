"""Independent solutions that tests compare with; nothing here imports the package."""
