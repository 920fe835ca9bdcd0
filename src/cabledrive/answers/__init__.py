"""What results declare of themselves: keys of JSON, figures for people, tables over time."""
