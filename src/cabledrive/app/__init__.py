"""The door: the command `cabledrive`, a few lines over public functions per subcommand."""
