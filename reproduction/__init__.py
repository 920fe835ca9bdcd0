"""The dissertation item by item: printed, computed, deviation, verdict."""

from reproduction.items import Entry, Item
from reproduction.run import Reproduction, reproduce

__all__ = ["Entry", "Item", "Reproduction", "reproduce"]
