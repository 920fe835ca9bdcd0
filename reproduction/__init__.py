"""The dissertation item by item: printed, computed, deviation, verdict."""

from reproduction.item import Entry, Item, Outcome
from reproduction.run import Reproduction, reproduce

__all__ = ["Entry", "Item", "Outcome", "Reproduction", "reproduce"]
