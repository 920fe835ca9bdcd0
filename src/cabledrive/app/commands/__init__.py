"""One file per subcommand, named after it, each with a click command named ``command``."""
