"""The chapters of a study's report, one file each in the order in which they are read, and its side files."""
