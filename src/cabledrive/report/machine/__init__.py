"""One machine of a report: its card, and the page behind it."""
