"""Pictures of machines and of their modes, drawn from the numbers they show."""
